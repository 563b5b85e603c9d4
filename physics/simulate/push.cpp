#include "physics/simulate/push.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "physics/body/driving_particles.h"
#include "physics/body/links.h"
#include "physics/simulate/loads.h"

namespace pliant {
namespace {

/// The same body with at most `count` particles, so that a trial is short: mass and volume are kept, log E and nu are
/// averaged by volume, law and object are those of one of the particles, and what was linked stays so.
Particles coarsen(const Particles& particles, int count) {
  if (static_cast<int>(particles.size()) <= count) return particles;
  SolidSamples samples;
  samples.position = particles.position;
  samples.volume = particles.volume;
  DriverOptions options;
  options.count = count;
  const DrivingParticles drivers = kmeans_drivers(options, samples);
  const size_t n = drivers.size();
  Particles out;
  out.materials = particles.materials;
  if (!particles.links.empty()) {
    std::vector<int> before(particles.size());
    std::iota(before.begin(), before.end(), 0);
    out.links = inherited_links(before, particles.links, drivers.sample_driver);
  }
  if (!particles.material_index.empty()) out.material_index.resize(n);
  if (!particles.object.empty()) out.object.resize(n);
  std::vector<double> volume(n), mass(n), log_young(n), poisson(n);
  for (size_t i = 0; i < particles.size(); ++i) {
    const int d = drivers.sample_driver[i];
    const double v = particles.volume[i];
    volume[d] += v;
    mass[d] += particles.mass[i];
    log_young[d] += v * std::log(particles.young[i]);
    poisson[d] += v * particles.poisson[i];
    if (!particles.material_index.empty()) out.material_index[d] = particles.material_index[i];
    if (!particles.object.empty()) out.object[d] = particles.object[i];
  }
  out.position = drivers.position;
  for (size_t d = 0; d < n; ++d) {
    out.volume.push_back(static_cast<float>(volume[d]));
    out.mass.push_back(static_cast<float>(mass[d]));
    out.young.push_back(static_cast<float>(std::exp(log_young[d] / volume[d])));
    out.poisson.push_back(static_cast<float>(poisson[d] / volume[d]));
  }
  out.cell_size = static_cast<float>(particles.cell_size * std::cbrt(static_cast<double>(particles.size()) / n));
  return out;
}

/// Region that surely holds particles of a coarser body: at least a cell in radius.
Region widened(const Region& region, double cell) {
  double radius = INFINITY;
  if (region.kind == Region::Kind::kSphere) radius = region.radius;
  if (region.kind == Region::Kind::kBox) radius = 0.5 * (region.vector - region.point).minCoeff();
  if (region.kind == Region::Kind::kCylinder)
    radius = std::min(region.radius, 0.5 * (region.vector - region.point).norm());
  return radius < cell ? region.grown(cell - radius) : region;
}

/// Mean force [N] over `duration` that a vector of length 1 makes on a body at rest.
double newtons_of_one(const Interaction& load, double mass, double duration) {
  switch (load.type) {
    case InteractionType::kImpulse:
      return 1 / duration;
    case InteractionType::kGust:
      return mass * (load.rate > 0 ? load.rate : 1);
    default:
      return 1;
  }
}

/// The body before the load: settled as the real run does, where no pin holds it.
SimulationState start_of(SimulateOptions options, const Particles& body, const std::vector<Interaction>& interactions) {
  options.grid = is_lagrangian(options, body) ? GridKind::kLagrangian : GridKind::kEulerian;
  options.rest_shape = RestShapeMode::kCaptured;  // of a pinned body, each trial solves it
  options.duration = 0;
  return simulate<float>(options, body, interactions, initial_state(body)).state;
}

/// Whether the real run starts from the captured shape itself.
bool starts_as_captured(const SimulateOptions& options, const Particles& body,
                        const std::vector<Interaction>& interactions) {
  if (LoadSchedule<float>(options, body, interactions).pinned(0)) return options.rest_shape == RestShapeMode::kCaptured;
  return options.settle_time == 0 || options.gravity.isZero();
}

struct Trial {
  double length = 0, peak = 0;  // peak displacement / height
};

/// What to try next: a length in proportion to the last trial's, from the third trial on one along the line of log peak
/// over log length through the last two; between the trials that were too weak and too strong, because the peak grows
/// with the load.
double next_length(const std::vector<Trial>& trials, double wanted) {
  constexpr double kLargestStep = 1e3, kFlattest = 0.5, kSteepest = 2, kMargin = 0.1;
  const Trial& last = trials.back();
  double slope = 1;
  if (trials.size() > 2) {
    const Trial& before = trials[trials.size() - 2];
    const double line = std::log(last.peak / before.peak) / std::log(last.length / before.length);
    if (line > 0) slope = std::clamp(line, kFlattest, kSteepest);
  }
  const double length =
      last.length * std::clamp(std::pow(wanted / last.peak, 1 / slope), 1 / kLargestStep, kLargestStep);
  const Trial *weak = nullptr, *strong = nullptr;
  for (const Trial& t : trials) {
    if (t.peak < wanted && (!weak || t.length > weak->length)) weak = &t;
    if (t.peak >= wanted && (!strong || t.length < strong->length)) strong = &t;
  }
  if (!weak || !strong || (weak->length < length && length < strong->length)) return length;
  const double share = std::log(wanted / weak->peak) / std::log(strong->peak / weak->peak);
  return weak->length * std::pow(strong->length / weak->length, std::clamp(share, kMargin, 1 - kMargin));
}

}  // namespace

LoadSize size_load(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Interaction& load) {
  const auto require = [](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error("push", field, "is " + std::to_string(value), remedy);
  };
  require(particles.size() > 0, "particles", 0, "seed the object first; it has no driving particle");
  require(load.vector.norm() > 0 && load.vector.allFinite(), "direction", load.vector.norm(),
          "give a direction that is not zero");
  require(options.fraction > 0 && options.fraction < 1, "fraction", options.fraction, "give a fraction of the height");
  require(options.duration > 0 && std::isfinite(options.duration), "duration", options.duration, "give seconds");
  require(options.trials > 0 && options.max_particles > 0, "trials", options.trials, "give a positive number");

  const Particles body = coarsen(particles, options.max_particles);
  double height = options.height;
  if (!(height > 0)) {
    double low = INFINITY, high = -INFINITY;
    for (const Vec3f& x : particles.position) {
      const double z = x.cast<double>().dot(options.up.normalized());
      low = std::min(low, z);
      high = std::max(high, z);
    }
    height = high - low;
  }
  require(height > 0, "height", height, "give the height of the body in meters");

  SimulateOptions trial = options.simulate;
  trial.duration = load.start + 2 * options.duration;  // a short push peaks after its end
  trial.cell_size = 0;
  const bool scaled =
      options.scale_on_body && body.size() < particles.size() && starts_as_captured(trial, particles, interactions);
  const SimulationState start = start_of(trial, body, interactions);
  trial.settle_time = 0;

  // Halving the cells halves the time steps.
  const double frames = std::lround(trial.fps * trial.duration),
               cost = std::pow(static_cast<double>(particles.size()) / static_cast<double>(body.size()), 4.0 / 3);
  const double work = frames * (options.trials + (scaled ? cost : 0));
  double done = 0;
  const auto try_out = [&](const Particles& of, const SimulationState& from, const Region& region, double length,
                           double cost_of_frame, double past) {
    Interaction push = load;
    push.region = region;
    push.vector = length * load.vector.normalized();
    std::vector<Interaction> script = interactions;
    script.push_back(push);
    double peak = 0;
    bool stopped = false;
    simulate<float>(trial, of, script, from, [&](const SimulationState& s) {
      double moved = 0;
      for (size_t i = 0; i < s.size(); ++i) moved = std::max(moved, static_cast<double>((s.x[i] - from.x[i]).norm()));
      peak = std::max(peak, moved);
      done += s.frame > 0 ? cost_of_frame : 0;
      stopped = options.go_on && !options.go_on(std::min(done / work, 1.0));
      return !stopped && (s.time < load.start + options.duration || moved >= past * peak);
    });
    if (stopped) throw Error(Failure::kInterrupted, "push", "", "interrupted", "run the same command again");
    require(peak > 0, "region", peak, "push where the body can move");
    return Trial{length, peak / height};
  };
  const auto miss = [&](const Trial& t) { return std::abs(std::log(t.peak / options.fraction)); };

  // A first load that would accelerate the body through the wanted way, were it free, and is small for a pinned one.
  constexpr double kNear = 0.05, kNearEnough = 0.3;  // where the body itself has the last word
  const double way = options.fraction * height, mass = body.total_mass();
  double length = options.first;
  if (!(length > 0))
    length =
        0.1 * mass * 2 * way / (options.duration * options.duration) / newtons_of_one(load, mass, options.duration);
  const Region wide = widened(load.region, body.cell_size);
  std::vector<Trial> trials;
  while (static_cast<int>(trials.size()) < options.trials) {
    trials.push_back(try_out(body, start, wide, length, 1, 0));
    if (std::abs(trials.back().peak / options.fraction - 1) < (scaled ? kNearEnough : kNear)) break;
    length = next_length(trials, options.fraction);
  }
  Trial best = *std::min_element(trials.begin(), trials.end(),
                                 [&](const Trial& a, const Trial& b) { return miss(a) < miss(b); });
  int count = static_cast<int>(trials.size());
  if (scaled) {
    constexpr double kPast = 0.8;  // of the peak: it will not come again
    done = options.trials * frames;
    best = try_out(particles, initial_state(particles), load.region, best.length, cost, kPast);
    ++count;
    if (std::abs(best.peak / options.fraction - 1) >= kNear)
      best = {best.length * options.fraction / best.peak, options.fraction};
  }
  return {best.length, best.peak, count};
}

PushSize size_push(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Region& region, const Vec3d& direction) {
  Interaction push;
  push.type = InteractionType::kPointForce;
  push.duration = options.duration;
  push.region = region;
  push.vector = direction;
  const LoadSize size = size_load(options, particles, interactions, push);
  return {size.length, size.peak_fraction, size.trials};
}

}  // namespace pliant
