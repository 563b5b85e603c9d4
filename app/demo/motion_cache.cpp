#include "app/demo/motion_cache.h"

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/demo/truth.h"
#include "app/store/trajectory.h"
#include "gaussians/base/error.h"
#include "gaussians/base/morton.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Changes when the solver or what is stored does, so that nothing older is taken.
constexpr int kCacheFormat = 2;

/// Indices of about `count` samples: every n-th along a space-filling curve.
std::vector<int> even_choice(const std::vector<Vec3f>& points, size_t count) {
  const std::vector<int> order = morton_order(points);
  std::vector<int> chosen;
  const size_t step = std::max<size_t>(1, points.size() / count);
  for (size_t i = 0; i < order.size(); i += step) chosen.push_back(order[i]);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::string key_of(const ReferenceBody& body, const std::vector<Interaction>& interactions,
                   const ReferenceOptions& options, size_t stored) {
  std::string text = Json{
      {"format", kCacheFormat},
      {"version", PLIANT_VERSION},
      {"interactions", interactions_json(interactions)},
      {"seconds", options.seconds},
      {"fps", options.fps},
      {"courant", options.courant},
      {"damping_time", options.damping_time},
      {"cell_size", body.cell_size},
      {"stored", stored}}.dump();
  const auto append = [&](const auto& values) {
    text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  append(body.particles.position);
  append(body.particles.volume);
  append(body.particles.mass);
  append(body.particles.young);
  append(body.particles.poisson);
  return sha256_of_text(text).substr(0, 32);
}

ReferenceMotion read_motion(const fs::path& file, const Json& figures, ReferenceMotion motion) {
  motion.time_step = figures.at("time_step");
  motion.max_stretch = figures.at("max_stretch");
  for (TrajectoryFile::Frame& frame : read_trajectory(file).frames) {
    SimulationState state;
    state.time = frame.time;
    state.frame = static_cast<int>(motion.frames.size());
    state.substeps = frame.step;
    state.x = std::move(frame.position);
    state.v = std::move(frame.velocity);
    state.F = std::move(frame.F);
    motion.frames.push_back(std::move(state));
  }
  return motion;
}

}  // namespace

ReferenceMotion thinned(const ReferenceMotion& motion, size_t count) {
  const std::vector<int> chosen = even_choice(motion.samples.position, count);
  ReferenceMotion out = motion;
  out.samples = motion.samples.select(chosen);
  // The same volume for fewer points.
  const double share = static_cast<double>(motion.samples.size()) / static_cast<double>(chosen.size());
  for (float& v : out.samples.volume) v = static_cast<float>(v * share);
  out.samples.spacing = static_cast<float>(motion.samples.spacing * std::cbrt(share));
  for (SimulationState& state : out.frames) {
    SimulationState some;
    some.time = state.time;
    some.frame = state.frame;
    some.substeps = state.substeps;
    for (const int i : chosen) {
      some.x.push_back(state.x[i]);
      some.v.push_back(state.v[i]);
      some.F.push_back(state.F[i]);
    }
    state = std::move(some);
  }
  return out;
}

ReferenceMotion cached_reference(const fs::path& cache, const ReferenceBody& body,
                                 const std::vector<Interaction>& interactions, const ReferenceOptions& options,
                                 size_t stored) {
  if (cache.empty()) return thinned(simulate_reference(body, interactions, options), stored);
  const std::string key = key_of(body, interactions, options, stored);
  const fs::path file = cache / (key + ".h5"), figures = cache / (key + ".json");
  // The trajectory is written last.
  std::error_code none;
  if (fs::exists(file, none) && fs::exists(figures, none)) {
    try {
      return read_motion(file, Json::parse(read_text(figures)),
                         thinned(without_frames(body, interactions, options), stored));
    } catch (const std::exception&) {
      // A damaged file is computed anew.
    }
  }
  const ReferenceMotion motion = thinned(simulate_reference(body, interactions, options), stored);
  try {
    fs::create_directories(cache);
    write_text(figures, Json{{"time_step", motion.time_step}, {"max_stretch", motion.max_stretch}}.dump() + "\n");
    write_trajectory(file, trajectory_of(motion, "object"), "{}");
  } catch (const std::exception&) {
    // What cannot be kept is simulated again the next time.
  }
  return motion;
}

fs::path demo_cache_folder() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder && *folder) return fs::path(folder) / "pliant/demo";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache/pliant/demo";
  return {};
}

}  // namespace pliant
