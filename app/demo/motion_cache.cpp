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

/// Changes when what is stored does, so that nothing older is taken.
constexpr int kCacheFormat = 3;

/// Of this process; found once, in about a tenth of a second.
const std::string& solver_digest() {
  static const std::string digest = digest_of(solver_sample());
  return digest;
}

/// Adds the bytes of values in single or double precision.
template <class Values>
void append_bytes(std::string& text, const Values& values) {
  text.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
}

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
  std::string text = Json{{"format", kCacheFormat},
                          {"version", PLIANT_VERSION},
                          {"solver", solver_digest()},
                          {"interactions", interactions_json(interactions)},
                          {"seconds", options.seconds},
                          {"fps", options.fps},
                          {"courant", options.courant},
                          {"damping_time", options.damping_time},
                          {"cell_size", body.cell_size},
                          {"stored", stored},
                          {"contact_friction", options.contact_friction}}
                         .dump();
  append_bytes(text, body.particles.position);
  append_bytes(text, body.particles.volume);
  append_bytes(text, body.particles.mass);
  append_bytes(text, body.particles.young);
  append_bytes(text, body.particles.poisson);
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

ReferenceMotion solver_sample() {
  // Three plates stand on one foot, 2 x 4 particles thick and wide, with 6.5 cells between the first two.
  constexpr double kSpacing = 0.005, kDensity = 500;
  constexpr double kVolume = kSpacing * kSpacing * kSpacing;
  ReferenceBody body;
  body.cell_size = 2 * kSpacing;
  Particles& particles = body.particles;
  particles.cell_size = static_cast<float>(body.cell_size);
  const auto add_block = [&](int left, int right, int bottom, int top) {
    for (int i = left; i < right; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = bottom; k < top; ++k) {
          particles.position.push_back((kSpacing * Vec3d(i + 0.5, j + 0.5, k + 0.5)).cast<float>());
          particles.volume.push_back(static_cast<float>(kVolume));
          particles.mass.push_back(static_cast<float>(kDensity * kVolume));
          particles.young.push_back(2e4f);
          particles.poisson.push_back(0.3f);
        }
  };
  add_block(0, 30, 0, 2);
  for (const int left : {0, 14, 28}) add_block(left, left + 2, 2, 16);
  const auto upper_half = [&](int left) {
    return Region::box(kSpacing * Vec3d(left, 0, 9), kSpacing * Vec3d(left + 2, 4, 16));
  };

  std::vector<Interaction> script;
  const auto act = [&](InteractionType type, const Region& region, const Vec3d& vector) -> Interaction& {
    script.emplace_back();
    script.back().type = type;
    script.back().region = region;
    script.back().vector = vector;
    return script.back();
  };
  act(InteractionType::kPin, Region::box(Vec3d(-1, -1, -1), Vec3d(1, 1, 2.4 * kSpacing)), Vec3d::Zero());
  // 0.8 m/s towards each other.
  act(InteractionType::kImpulse, upper_half(0), Vec3d(2.8e-3, 0, 0));
  act(InteractionType::kImpulse, upper_half(14), Vec3d(-2.8e-3, 0, 0));
  act(InteractionType::kPointForce, upper_half(0), Vec3d(0, 2e-3, 0)).duration = 0.04;
  Interaction& gust = act(InteractionType::kGust, Region::all(), Vec3d(0, 0.5, 0));
  gust.duration = 0.05;
  gust.rate = 0.5;
  // From the centre of the third plate's upper half.
  const Vec3d held = kSpacing * Vec3d(29, 2, 12.5), drawn = held + Vec3d(0, 0.004, 0);
  act(InteractionType::kGrab, upper_half(28), Vec3d::Zero()).path = {{0, held}, {0.05, drawn}};

  ReferenceOptions options;
  options.seconds = 0.07;
  options.fps = 400;
  return simulate_reference(body, script, options);
}

std::string digest_of(const ReferenceMotion& motion) {
  std::string bytes;
  for (const SimulationState& state : motion.frames) {
    append_bytes(bytes, state.x);
    append_bytes(bytes, state.v);
    append_bytes(bytes, state.F);
  }
  return sha256_of_text(bytes).substr(0, 32);
}

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
