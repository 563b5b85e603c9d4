// What a page's level of driving particles costs: a recording done again at its level and with all driving particles of
// the simulation.  Prints JSON: difference of the mean way of what each grab held, and of every driving particle of
// the level against the nearest one at rest of all, largest over the frames and at the end, in % of the object's
// height. Usage: level_study RUN_DIR RECORDING.json (recording.h5 of the object is written again)

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/live/recording.h"
#include "app/run/attach_scene.h"
#include "app/store/particles.h"
#include "app/store/trajectory.h"
#include "gaussians/base/nearest.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

using nlohmann::json;

struct Replayed {
  ParticleFile level;
  std::vector<TrajectoryFile::Frame> frames;
  double fps = 0;
};

Replayed replayed(const Context& context, RunDirectory& run, const Scene& scene, const std::filesystem::path& file) {
  replay_recording(context, run, scene, file);
  const std::filesystem::path folder = run / object_folder(run);
  const TrajectoryFile motion = read_trajectory(folder / "recording.h5");
  return {read_particles(folder / "recording_particles.h5"), motion.frames, motion.fps};
}

/// Mean way, from another frame to this one, of the particles that a region holds at the other.
Vec3d mean_way(const Replayed& of, const Region& region, double metres, int held_at, int frame) {
  Vec3d sum = Vec3d::Zero();
  int count = 0;
  const std::vector<Vec3f>&from = of.frames[held_at].position, &to = of.frames[frame].position;
  for (size_t i = 0; i < from.size(); ++i)
    if (region.contains(metres * from[i].cast<double>())) {
      sum += (to[i] - from[i]).cast<double>();
      ++count;
    }
  return sum / std::max(count, 1);
}

json largest_and_last(std::vector<double> percent) {
  return {{"largest_percent", *std::ranges::max_element(percent)}, {"last_percent", percent.back()}};
}

int study(const char* folder, const char* recording) {
  Progress silent(true);
  const Context context{silent, [] { return false; }};
  RunDirectory run = RunDirectory::open(folder);
  const Scene scene = load_run_scene(run);
  const Recording done = parse_recording(read_text(recording), scene, recording);
  const LiveScene live = load_live_scene(run, scene, "level_study");
  json full = json::parse(read_text(recording));
  full["drivers"] = live.drivers();
  full["clustered_to"] = 0;
  const std::filesystem::path other = run / "level_study.json";
  write_text(other, full.dump());
  const Replayed coarse = replayed(context, run, scene, recording), fine = replayed(context, run, scene, other);
  std::filesystem::remove(other);

  const double metres = scene.metres_per_unit, height = live.setup.height / metres;
  json grabs = json::array();
  for (const Interaction& it : done.interactions) {
    if (it.type != InteractionType::kGrab) continue;
    const int begin = std::min(static_cast<int>(std::lround(it.start * coarse.fps)), done.frames);
    std::vector<double> percent;
    for (int f = begin; f <= done.frames; ++f)
      percent.push_back(
          100 / height *
          (mean_way(coarse, it.region, metres, begin, f) - mean_way(fine, it.region, metres, begin, f)).norm());
    grabs.push_back(largest_and_last(percent));
  }
  const std::vector<int> twin = k_nearest(fine.level.driving_position, coarse.level.driving_position, 1);
  std::vector<double> rms;
  for (int f = 0; f <= done.frames; ++f) {
    double square = 0;
    for (size_t i = 0; i < twin.size(); ++i) {
      const Vec3f moved = coarse.frames[f].position[i] - coarse.level.driving_position[i];
      const Vec3f there = fine.frames[f].position[twin[i]] - fine.level.driving_position[twin[i]];
      square += (moved - there).squaredNorm() / static_cast<double>(twin.size());
    }
    rms.push_back(100 / height * std::sqrt(square));
  }
  std::puts(json({{"drivers", done.start.drivers},
                  {"all", live.drivers()},
                  {"frames", done.frames},
                  {"grabs", grabs},
                  {"body_rms", largest_and_last(rms)}})
                .dump(1)
                .c_str());
  return 0;
}

}  // namespace
}  // namespace pliant

int main(int count, char** words) {
  if (count != 3) return std::puts("usage: level_study RUN_DIR RECORDING.json"), 2;
  return pliant::study(words[1], words[2]);
}
