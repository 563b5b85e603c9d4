#include "app/fit/named_video.h"

#include <algorithm>
#include <optional>

#include "app/run/physdreamer_scene.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace fs = std::filesystem;

std::string known_camera(const Scene& scene, const FitStage& stage) {
  if (stage.camera() == kFindCamera) return "";
  if (!stage.camera().empty()) return stage.camera();
  return scene.settings.video && !stage.beside ? scene.settings.video->camera : "";
}

NamedVideo named_video(const Scene& scene, const FitStage& stage) {
  const auto& known = scene.settings.video;
  if (stage.video().empty() && !known)
    throw usage_error("fit", "--video", "is not given, and the scene has no reference video",
                      "give --video FILE, with --video-camera NAME where the camera is known");
  NamedVideo out;
  out.file = stage.video().empty() ? known->file : fs::path(stage.video());
  out.camera = known_camera(scene, stage);
  if (stage.video().empty()) out.fps = known->fps;
  const std::optional<PhysDreamerFolder> folder = physdreamer_folder(scene);
  // Of such a folder, a camera names its video too.
  if (folder && stage.video().empty() && !stage.camera().empty()) {
    const auto its = std::find_if(folder->videos.begin(), folder->videos.end(),
                                  [&](const auto& video) { return video.camera == stage.camera(); });
    if (its != folder->videos.end()) out.file = its->file;
  }
  if (const PhysDreamerFolder::Video* listed = folder ? folder->find_video(out.file) : nullptr) {
    out.physdreamer = out.fps_holds = true;
    out.fps = kPhysDreamerFps;
    if (stage.camera().empty()) out.camera = listed->camera;
  }
  if (stage.fps > 0) {
    out.fps = stage.fps;
    out.fps_holds = true;
  }
  return out;
}

}  // namespace pliant
