#include "app/render/render_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "app/render/object_layer.h"
#include "app/run/attach_scene.h"
#include "app/simulate/clip_camera.h"
#include "app/simulate/moving_scene.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/render/render.h"
#include "gaussians/vision/resize.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kSwing = 25;    // degrees
constexpr double kWidest = 640;  // pixels of a picture of the contact sheet

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

/// Eight moments of a clip, evenly spread, at most 640 pixels wide.
class Moments {
 public:
  explicit Moments(size_t frames) : frames_(frames) {}
  void offer(size_t f, const ImageF& picture) {
    if (pictures.size() == 8 || f < pictures.size() * frames_ / 8) return;
    const int height = std::max(1, static_cast<int>(std::lround(picture.height * kWidest / picture.width)));
    pictures.push_back(picture.width > kWidest ? resized(picture, static_cast<int>(kWidest), height) : picture);
  }
  std::vector<ImageF> pictures;

 private:
  size_t frames_;
};

json render_clip(const Context& context, const RunDirectory& run, const StageInputs<RenderStage>& in,
                 const std::string&) {
  const RenderStage& stage = in.options;
  const Scene& scene = in.scene;
  const MovingScene moving = load_moving_scene(in.files, scene);
  RenderOptions options;
  options.antialiased = moving.antialiased;
  options.background = scene.settings.background_color();
  const Box bounds = robust_bounds(moving.object);
  const Shot shot = clip_shot(stage.shot, scene, moving.trajectory, bounds);
  for (const std::string& warning : shot.warnings) context.progress.warn(warning);
  const Camera& first = shot.cameras[0];
  const size_t frames = shot.times.size();

  Moments moments(frames);
  context.progress.begin("render", static_cast<int>(stage.orbit ? 2 * frames : frames));
  const fs::path unfinished = run / "clip.partial", layers = run / "clip_object.partial";
  fs::remove_all(unfinished);
  fs::remove_all(layers);
  if (stage.frames) fs::create_directories(unfinished);
  std::optional<ObjectLayer> layer;
  if (stage.layer)
    layer.emplace(layers, run / "clip_object.webm", shot, farthest_depth(shot, moving.trajectory, bounds),
                  scene.metres_per_unit);
  int done = 0;
  const auto film = [&](const char* file, const Shot& taken,
                        const std::function<void(size_t, const TrajectoryFile::Frame&, const ImageF&)>& also) {
    VideoWriter clip(run / file, taken.fps, first.width, first.height);
    for (size_t k = 0; k < frames; ++k) {
      if (context.interrupted())
        throw Error(Failure::kInterrupted, "render", "", "interrupted", "run the same command to continue");
      const TrajectoryFile::Frame frame = moving.trajectory.at(taken.times[k]);
      const ImageF picture = render(moving.all_at(frame), taken.cameras[k], options).color;
      clip.write(picture);
      if (also) also(k, frame, picture);
      context.progress.done(++done);
    }
    clip.close();
  };
  film("clip.mp4", shot, [&](size_t k, const TrajectoryFile::Frame& frame, const ImageF& picture) {
    if (stage.frames) write_image(unfinished / fmt::format("{:06d}.png", k), picture);
    if (layer) layer->write(k, moving.object_at(frame), options);
    moments.offer(k, picture);
  });
  // Photographed scenes are seen from one side only, so the moving camera swings; others are circled once.
  if (stage.orbit)
    film("clip_orbit.mp4",
         turning_shot(shot, stage.turntable || scene.cameras_are_orbit ? 360 : kSwing, bounds, scene.up), {});
  context.progress.end();
  if (layer) layer->close();
  for (const auto& [from, to, wanted] :
       {std::tuple(unfinished, run / "clip", stage.frames), std::tuple(layers, run / "clip_object", stage.layer)}) {
    if (!wanted) continue;
    fs::remove_all(to);
    fs::rename(from, to);
  }
  if (stage.gif) convert_video(run / "clip.mp4", run / "clip.gif");
  if (stage.webp) convert_video(run / "clip.mp4", run / "clip.webp");
  write_contact_sheet(run / "clip_frames.png", moments.pictures);
  return {{"frames", frames},
          {"camera", first.name},
          {"width", first.width},
          {"height", first.height},
          {"fps", shot.fps},
          {"moving_gaussians", moving.moving()},
          {"object_gaussians", moving.object.size()}};
}

}  // namespace

void check_render_stage(const Scene& scene, const RenderStage& stage) {
  if (stage.turntable && !stage.orbit)
    throw usage_error("--turntable", "", "was given together with --no-orbit", "leave one of them out");
  check_shot(stage.shot, scene);
}

StageInputs<RenderStage> inputs_of(const RunDirectory& run, const Scene& scene, const RenderStage& stage) {
  check_render_stage(scene, stage);
  StageInputs<RenderStage> in;
  in.options = stage;
  in.parts = {ScenePart::kDrawing, ScenePart::kCameras, ScenePart::kUp, ScenePart::kMetresPerUnit};
  if (stage.shot.camera.empty() && stage.shot.path.empty()) in.parts.insert(ScenePart::kVideoCamera);
  in.scene = only(in.parts, scene);
  in.files = stage.recorded ? recorded_scene_files(run) : moving_scene_files(run);
  in.outputs = {"clip.mp4", "clip_frames.png"};
  if (stage.frames) in.outputs.push_back("clip");
  if (stage.gif) in.outputs.push_back("clip.gif");
  if (stage.webp) in.outputs.push_back("clip.webp");
  if (stage.layer) {
    in.outputs.push_back("clip_object");
    in.outputs.push_back("clip_object.webm");
  }
  if (stage.orbit) in.outputs.push_back("clip_orbit.mp4");
  return in;
}

json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& stage) {
  const StageInputs<RenderStage> in = inputs_of(run, scene, stage);
  if (stage.recorded) check_recorded_object(in.files);
  return run_stage(context, run, in, render_clip);
}

OptionTable options_of(RenderStage& stage) {
  return {
      "render",
      {{.name = "camera",
        .field = &stage.shot.camera,
        .help = "Camera of clip.mp4 (default: the video's, else a clear view of the object)",
        .value = "NAME"},
       {.name = "cameras",
        .field = &stage.shot.path,
        .help = "Camera path of clip.mp4: camera_path.json of nerfstudio, or a camera file (30 poses a second)",
        .value = "FILE",
        .recorded = Recorded::kContents},
       {.name = "size",
        .field = &stage.shot.size,
        .help = "Size of the clips [px], even; nothing is cut (default: the camera's)",
        .value = "WxH"},
       {.name = "clip-fps",
        .field = &stage.shot.fps,
        .help = "Frames per second of the clips, between those of the simulation (default: the path's or simulation's)",
        .low = 1,
        .high = 1000},
       {.name = "recorded",
        .field = &stage.recorded,
        .help = "Film what was done by hand, recording.h5 of `simulate --recording`, instead of the simulated motion"},
       {.name = "no-orbit", .field = &stage.orbit, .help = "Skip clip_orbit.mp4", .off = true},
       {.name = "turntable",
        .field = &stage.turntable,
        .help = "Let clip_orbit.mp4 turn once around the object, also where photos show one side only"},
       {.name = "gif", .field = &stage.gif, .help = "Also write clip.gif"},
       {.name = "webp", .field = &stage.webp, .help = "Also write clip.webp, animated"},
       {.name = "frames", .field = &stage.frames, .help = "Also write the frames of clip.mp4 as PNG, into clip/"},
       {.name = "object-layer",
        .field = &stage.layer,
        .help = "Also write the object alone with alpha and depth: clip_object/ (PNG) and clip_object.webm"}}};
}

}  // namespace pliant
