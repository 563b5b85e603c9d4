#include <fmt/format.h>

#include <functional>

#include "app/pipeline/clip_camera.h"
#include "app/pipeline/interactions.h"
#include "app/pipeline/stages.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"
#include "gaussians/io/image_io.h"
#include "gaussians/io/ply.h"
#include "gaussians/io/video.h"
#include "gaussians/render/deform.h"
#include "gaussians/render/render.h"

namespace pliant {
using nlohmann::json;

namespace {

/// The object at rest, what moves it, and the background it stands in.
struct Stage {
  GaussianCloud object, background;
  ParticleFile particles;
  TrajectoryFile trajectory;
  Binding binding;
  RenderOptions options;
};

/// Gaussians inside a pinned region belong to the rigid part and follow no driver.
void hold_pinned(const Stage& stage, const Scene& scene, Binding& binding) {
  const InteractionFrame frame{scene.metres_per_unit, scene.up};
  for (const json& row : json::parse(stage.particles.pinned_json)) {
    const Region region = parse_region(row, frame, "particles.h5");
    for (size_t i = 0; i < stage.object.size(); ++i)
      if (region.contains(stage.object.position[i].cast<double>())) binding.driver[i * Binding::kCount] = -1;
  }
}

ImageF picture_of_frame(const Stage& stage, const TrajectoryFile::Frame& frame, const Camera& camera) {
  GaussianCloud moved;
  deform({}, stage.object, stage.binding, stage.particles.driving_position, frame.position, frame.F, moved);
  GaussianCloud all = stage.background;
  all.append(moved);
  return render(all, camera, stage.options).color;
}

/// A few moments of the clip side by side, for the report.
void write_contact_sheet(const std::filesystem::path& file, const std::vector<ImageF>& pictures) {
  const int columns = 4, rows = static_cast<int>((pictures.size() + columns - 1) / columns);
  const int width = pictures[0].width, height = pictures[0].height;
  ImageF sheet(columns * width, rows * height, 3, 1.0f);
  for (size_t k = 0; k < pictures.size(); ++k)
    for (int y = 0; y < height; ++y)
      std::copy_n(pictures[k].at(0, y), width * 3, sheet.at(static_cast<int>(k % columns) * width, static_cast<int>(k / columns) * height + y));
  write_image(file, sheet);
}

}  // namespace

json run_render(const Context& context, RunDirectory& run, const Scene& scene, const RenderStage& options) {
  const std::string folder = object_folder(run);
  run.summary("simulate", "run `pliant simulate` first");
  StageKey key{"render",
               {{"camera", options.camera}, {"orbit", options.orbit}},
               {{"object", run / (folder + "/object.ply")},
                {"background", run / "background_repaired.ply"},
                {"trajectory", run / (folder + "/trajectory.h5")}},
               {"clip.mp4", "clip_frames.png"}};
  if (options.orbit) key.outputs.push_back("clip_orbit.mp4");
  return run.stage(context, key, [&]() -> json {
    Stage stage;
    stage.object = read_ply(run / (folder + "/object.ply"));
    stage.background = read_ply(run / "background_repaired.ply");
    stage.particles = read_particles(run / (folder + "/particles.h5"));
    stage.trajectory = read_trajectory(run / (folder + "/trajectory.h5"));
    stage.options.antialiased = scene.report.antialiased;
    stage.binding = pliant::bind({}, stage.object.position, stage.particles.driving_position);
    hold_pinned(stage, scene, stage.binding);
    size_t moving = 0;
    for (size_t i = 0; i < stage.binding.size(); ++i) moving += stage.binding.driver[i * Binding::kCount] >= 0;

    const Box bounds = robust_bounds(stage.object);
    const Camera fixed = clip_camera(scene, options.camera, bounds);
    const int frames = static_cast<int>(stage.trajectory.frames.size());
    // Photographed scenes are seen from one side only, so the moving camera swings; others are circled once.
    OrbitPathOptions turn;
    turn.frames = frames, turn.degrees = scene.cameras_are_orbit ? 360 : 25;
    const std::vector<Camera> path = orbit_path(turn, fixed, bounds.centre().cast<double>(), scene.up);

    std::vector<ImageF> moments;
    context.progress.begin("render", options.orbit ? 2 * frames : frames);
    const auto film = [&](const std::string& file, int done, const std::function<const Camera&(int)>& camera) {
      VideoWriter clip(run / file, stage.trajectory.fps, fixed.width, fixed.height);
      for (int f = 0; f < frames; ++f) {
        if (context.interrupted()) throw Error(Failure::kInterrupted, "render", "", "interrupted", "run the same command to continue");
        const ImageF picture = picture_of_frame(stage, stage.trajectory.frames[f], camera(f));
        clip.write(picture);
        if (static_cast<int>(moments.size()) < 8 && f >= static_cast<int>(moments.size()) * frames / 8) moments.push_back(picture);
        context.progress.done(done + f + 1);
      }
      clip.close();
    };
    film("clip.mp4", 0, [&](int) -> const Camera& { return fixed; });
    if (options.orbit) film("clip_orbit.mp4", frames, [&](int f) -> const Camera& { return path[f]; });
    context.progress.end();
    write_contact_sheet(run / "clip_frames.png", moments);
    return {{"frames", frames}, {"camera", fixed.name}, {"width", fixed.width}, {"height", fixed.height},
            {"fps", stage.trajectory.fps}, {"moving_gaussians", moving}, {"object_gaussians", stage.object.size()}};
  });
}

}  // namespace pliant
