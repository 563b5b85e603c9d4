#include "app/live/live_scene.h"

#include <fmt/format.h>

#include "app/run/attach_scene.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

ParticleFile level_of(const LiveScene& scene, const LiveStart& start, const std::string& where) {
  const ParticleFile& file = scene.moving.particles;
  ParticleFile level = start.clustered_to > 0 ? with_drivers(file, scene.scene, start.clustered_to) : file;
  const size_t found = level.driving_position.size();
  if (start.drivers == 0 || found == start.drivers) return level;
  throw input_error(where, "drivers", fmt::format("is {}; the object has {}", start.drivers, found),
                    "use the run directory that the page was made from");
}

size_t checked_frame(const LiveScene& scene, const LiveStart& start, const std::string& where) {
  const size_t frames = scene.moving.trajectory.frames.size();
  if (scene.setup.remembers && start.frame > 0)
    throw input_error(where, "start_frame", fmt::format("is {}", start.frame),
                      "begin with frame 0: only of that is known what the material remembers");
  if (start.frame < frames) return start.frame;
  throw input_error(where, "start_frame", fmt::format("is {}", start.frame),
                    fmt::format("the clip has {} frames", frames));
}

}  // namespace

LiveScene load_live_scene(const RunDirectory& run, const Scene& scene, const std::string& what) {
  LiveScene out{scene, load_moving_scene(moving_scene_files(run), scene), {}, {}, record_of_motion(run)};
  out.object = extracted(run, {"name"})["name"];
  out.setup = session_setup(run, scene, out.moving);
  if (!out.setup.refused.empty())
    throw usage_error(what, "", "cannot be moved interactively: " + out.setup.refused, "simulate again");
  return out;
}

LiveBody::LiveBody(const LiveScene& scene, const LiveStart& start, const std::string& where)
    : level(level_of(scene, start, where)),
      body(make_body(level, scene.scene, scene.setup.solid, scene.setup.material)) {
  const MovingScene& moving = scene.moving;
  state = state_of(motion_of(moving, level), checked_frame(scene, start, where), moving.trajectory.fps,
                   scene.scene.metres_per_unit, body.particles, memory_of(moving, level));
}

}  // namespace pliant
