#include "app/simulate/render_stage.h"

#include <fmt/format.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "app/simulate/clip_camera.h"
#include "app/simulate/moving_scene.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/render.h"

namespace pliant {
using nlohmann::json;

namespace {

/// A few moments of the clip side by side, for the report.
void write_contact_sheet(const std::filesystem::path& file, const std::vector<ImageF>& pictures) {
  const int columns = 4, rows = static_cast<int>((pictures.size() + columns - 1) / columns);
  const int width = pictures[0].width, height = pictures[0].height;
  ImageF sheet(columns * width, rows * height, 3, 1.0f);
  for (size_t k = 0; k < pictures.size(); ++k)
    for (int y = 0; y < height; ++y)
      std::copy_n(pictures[k].at(0, y), width * 3,
                  sheet.at(static_cast<int>(k % columns) * width, static_cast<int>(k / columns) * height + y));
  write_image(file, sheet);
}

json render_clip(const Context& context, const RunDirectory& run, const StageInputs<RenderStage>& in,
                 const std::string&) {
  const RenderStage& options = in.options;
  const Scene& scene = in.scene;
  const MovingScene moving = load_moving_scene(in.files, scene);
  RenderOptions render_options;
  render_options.antialiased = moving.antialiased;

  const Box bounds = robust_bounds(moving.object);
  const Camera fixed = clip_camera(scene, options.camera, bounds);
  const int frames = static_cast<int>(moving.trajectory.frames.size());
  // Photographed scenes are seen from one side only, so the moving camera swings; others are circled once.
  OrbitPathOptions turn;
  turn.frames = frames;
  turn.degrees = scene.cameras_are_orbit ? 360 : 25;
  const std::vector<Camera> path = orbit_path(turn, fixed, bounds.centre().cast<double>(), scene.up);

  std::vector<ImageF> moments;
  context.progress.begin("render", options.orbit ? 2 * frames : frames);
  const std::filesystem::path unfinished = run / "clip.partial";
  std::filesystem::remove_all(unfinished);
  if (options.frames) std::filesystem::create_directories(unfinished);
  const auto film = [&](const std::string& file, int done, const std::function<const Camera&(int)>& camera) {
    VideoWriter clip(run / file, moving.trajectory.fps, fixed.width, fixed.height);
    for (int f = 0; f < frames; ++f) {
      if (context.interrupted())
        throw Error(Failure::kInterrupted, "render", "", "interrupted", "run the same command to continue");
      const ImageF picture = render(moving.all_at(moving.trajectory.frames[f]), camera(f), render_options).color;
      clip.write(picture);
      if (options.frames && done == 0) write_image(unfinished / fmt::format("{:06d}.png", f), picture);
      if (static_cast<int>(moments.size()) < 8 && f >= static_cast<int>(moments.size()) * frames / 8)
        moments.push_back(picture);
      context.progress.done(done + f + 1);
    }
    clip.close();
  };
  film("clip.mp4", 0, [&](int) -> const Camera& { return fixed; });
  if (options.orbit) film("clip_orbit.mp4", frames, [&](int f) -> const Camera& { return path[f]; });
  context.progress.end();
  if (options.frames) {
    std::filesystem::remove_all(run / "clip");
    std::filesystem::rename(unfinished, run / "clip");
  }
  write_contact_sheet(run / "clip_frames.png", moments);
  return {{"frames", frames},
          {"camera", fixed.name},
          {"width", fixed.width},
          {"height", fixed.height},
          {"fps", moving.trajectory.fps},
          {"moving_gaussians", moving.moving()},
          {"object_gaussians", moving.object.size()}};
}

}  // namespace

StageInputs<RenderStage> inputs_of(const RunDirectory& run, const Scene& scene, const RenderStage& stage) {
  StageInputs<RenderStage> in;
  in.options = stage;
  in.parts = {ScenePart::kAntialiased, ScenePart::kCameras, ScenePart::kUp, ScenePart::kMetresPerUnit};
  if (stage.camera.empty()) in.parts.insert(ScenePart::kVideoCamera);
  in.scene = only(in.parts, scene);
  in.files = moving_scene_files(run);
  in.outputs = {"clip.mp4", "clip_frames.png"};
  if (stage.frames) in.outputs.push_back("clip");
  if (stage.orbit) in.outputs.push_back("clip_orbit.mp4");
  return in;
}

json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& stage) {
  return run_stage(context, run, inputs_of(run, scene, stage), render_clip);
}

OptionTable options_of(RenderStage& stage) {
  return {"render",
          {{.name = "camera",
            .field = &stage.camera,
            .help = "Camera of clip.mp4 (default: the video's, else a clear view of the object)",
            .value = "NAME"},
           {.name = "no-orbit", .field = &stage.orbit, .help = "Skip clip_orbit.mp4", .off = true},
           {.name = "frames", .field = &stage.frames, .help = "Also write the frames of clip.mp4 as PNG, into clip/"}}};
}

}  // namespace pliant
