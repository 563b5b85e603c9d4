#include "physics/simulate/push.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "gaussians/base/error.h"
#include "physics/body/driving_particles.h"
#include "physics/body/links.h"
#include "physics/simulate/loads.h"

namespace pliant {
namespace {

void require(bool good, const char* field, double value, const char* remedy) {
  if (!good) throw usage_error("push", field, "is " + std::to_string(value), remedy);
}

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

/// The body before the load: settled as the real run does, where its gravity is not cancelled.
SimulationState start_of(SimulateOptions options, const Particles& body, const std::vector<Interaction>& interactions) {
  options.grid = is_lagrangian(options, body) ? GridKind::kLagrangian : GridKind::kEulerian;
  options.rest_shape = RestShapeMode::kCaptured;  // of a pinned body, each trial solves it
  options.duration = 0;
  return simulate<float>(options, body, interactions, initial_state(body)).state;
}

/// Whether the real run starts from the captured shape itself.
bool starts_as_captured(const SimulateOptions& options, const Particles& body,
                        const std::vector<Interaction>& interactions) {
  const LoadSchedule<float> schedule(options, body, interactions);
  if (options.rest_shape == RestShapeMode::kSolve && schedule.pinned(0)) return false;
  return schedule.cancels_gravity(0) || options.settle_time == 0 || options.gravity.isZero();
}

/// The displacement that all but `loose_share` of the mass of these particles stays below.
double displacement(const Particles& body, const std::vector<int>& touched, double loose_share,
                    const SimulationState& start, const SimulationState& now) {
  std::vector<std::pair<float, float>> moved;  // displacement, mass
  double loose = 0;
  for (const int p : touched) {
    moved.emplace_back((now.x[p] - start.x[p]).norm(), body.mass[p]);
    loose += loose_share * body.mass[p];
  }
  std::sort(moved.begin(), moved.end(), std::greater<>());
  for (const auto& [way, mass] : moved)
    if ((loose -= mass) < 0) return way;
  return 0;
}

/// What a load of a length does: the peak displacement, relative to the height.
struct Trial {
  double length = 0, peak = 0;
};

/// Short clips of a load, from so much work in all, of which it tells how much is done.
class Trials {
 public:
  Trials(const PushOptions& options, const SimulateOptions& simulate, const std::vector<Interaction>& interactions,
         const Interaction& load, double height, double work)
      : options_(options),
        simulate_(simulate),
        interactions_(interactions),
        load_(load),
        height_(height),
        work_(work) {}

  /// A load on `region` of `body`, each frame of which is so much work.
  Trial run(const Particles& body, const SimulationState& start, const Region& region, double length,
            double work_of_frame) {
    constexpr double kPast = 0.8;  // of the peak: it will not come again
    std::vector<Interaction> script = interactions_;
    script.push_back(load_);
    script.back().region = region;
    script.back().vector = length * load_.vector.normalized();
    std::vector<int> counted;
    for (size_t p = 0; p < body.size(); ++p)
      if (!options_.loose_share || region.contains(body.position[p].cast<double>()))
        counted.push_back(static_cast<int>(p));
    double peak = 0;
    simulate<float>(simulate_, body, script, start, [&](const SimulationState& s) {
      const double moved = displacement(body, counted, options_.loose_share.value_or(0), start, s);
      peak = std::max(peak, moved);
      tell(s.frame > 0 ? work_of_frame : 0);
      return s.time < load_.start + options_.duration || moved >= kPast * peak;
    });
    require(peak > 0, "region", peak, "push where the body can move");
    return {length, peak / height_};
  }

  /// So much work was done at least, or need not be.
  void set_done(double work) { done_ = std::max(done_, work); }

 private:
  void tell(double work) {
    done_ += work;
    if (options_.go_on && !options_.go_on(std::min(done_ / work_, 1.0)))
      throw Error(Failure::kInterrupted, "push", "", "interrupted", "run the same command again");
  }

  const PushOptions& options_;
  const SimulateOptions& simulate_;
  const std::vector<Interaction>& interactions_;
  const Interaction& load_;
  double height_, work_, done_ = 0;
};

/// The strongest trial that is too weak and the weakest that is strong enough.
struct Bracket {
  const Trial *weak = nullptr, *strong = nullptr;
};
Bracket bracket_of(const std::vector<Trial>& trials, double wanted) {
  Bracket found;
  for (const Trial& t : trials) {
    const Trial*& end = t.peak < wanted ? found.weak : found.strong;
    if (!end || (t.peak < wanted ? t.length > end->length : t.length < end->length)) end = &t;
  }
  return found;
}

/// What to try next: a length in proportion to the last trial's, from the third trial on one along the line of log peak
/// over log length through the last two; between the trials that were too weak and too strong, because the peak grows
/// with the load, and after `usual` trials in their middle.
double next_length(const std::vector<Trial>& trials, double wanted, double largest_step, size_t usual) {
  constexpr double kFlattest = 0.5, kSteepest = 2, kMargin = 0.1;
  const Trial& last = trials.back();
  const auto [weak, strong] = bracket_of(trials, wanted);
  if (weak && strong && trials.size() >= usual) return std::sqrt(weak->length * strong->length);
  double slope = 1;
  if (trials.size() > 2) {
    const Trial& before = trials[trials.size() - 2];
    const double line = std::log(last.peak / before.peak) / std::log(last.length / before.length);
    if (line > 0) slope = std::clamp(line, kFlattest, kSteepest);
  }
  const double length =
      last.length * std::clamp(std::pow(wanted / last.peak, 1 / slope), 1 / largest_step, largest_step);
  if (!weak || !strong || (weak->length < length && length < strong->length)) return length;
  const double share = std::log(wanted / weak->peak) / std::log(strong->peak / weak->peak);
  return weak->length * std::pow(strong->length / weak->length, std::clamp(share, kMargin, 1 - kMargin));
}

/// Height along up that is given, or that of the particles [m].
double height_of(const PushOptions& options, const Particles& particles) {
  if (options.height > 0) return options.height;
  double low = INFINITY, high = -INFINITY;
  for (const Vec3f& x : particles.position) {
    const double z = x.cast<double>().dot(options.up.normalized());
    low = std::min(low, z);
    high = std::max(high, z);
  }
  require(high > low, "height", high - low, "give the height of the body in meters");
  return high - low;
}

/// A load that would accelerate the body through the wanted way, were it free, and is small for a pinned one.
double first_length(const PushOptions& options, const Interaction& load, double mass, double height) {
  constexpr double kShare = 0.1;
  const double way = options.fraction * height, newtons = 2 * mass * way / (options.duration * options.duration);
  return kShare * newtons / newtons_of_one(load, mass, options.duration);
}

}  // namespace

LoadSize size_load(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Interaction& load) {
  constexpr double kNear = 0.05, kNearEnough = 0.3;  // where the body itself has the last word
  constexpr double kFar = 0.5;                       // where scaling cannot be relied on
  constexpr size_t kMostTrials = 10;
  require(particles.size() > 0, "particles", 0, "seed the object first; it has no driving particle");
  require(load.vector.norm() > 0 && load.vector.allFinite(), "direction", load.vector.norm(),
          "give a direction that is not zero");
  require(options.fraction > 0 && options.fraction < 1, "fraction", options.fraction, "give a fraction of the height");
  require(options.duration > 0 && std::isfinite(options.duration), "duration", options.duration, "give seconds");
  require(options.trials > 0 && options.max_particles > 0, "trials", options.trials, "give a positive number");
  const double height = height_of(options, particles), wanted = options.fraction;
  const auto miss = [&](const Trial& trial) { return std::abs(trial.peak / wanted - 1); };

  const Particles body = coarsen(particles, options.max_particles);
  SimulateOptions clip = options.simulate;
  clip.duration = load.start + 2 * options.duration;  // a short push peaks after its end
  clip.cell_size = 0;
  const bool scaled =
      options.scale_on_body && body.size() < particles.size() && starts_as_captured(clip, particles, interactions);
  const SimulationState start = start_of(clip, body, interactions);
  clip.settle_time = 0;

  // The work of a frame of the body itself, in frames of the coarser one: halving the cells halves the time steps.
  const double ratio = static_cast<double>(particles.size()) / static_cast<double>(body.size()),
               cost = std::pow(ratio, 4.0 / 3);
  const double frames = std::lround(clip.fps * clip.duration), coarse_work = frames * options.trials;
  Trials trials(options, clip, interactions, load, height, coarse_work + (scaled ? frames * cost : 0));

  // What nothing holds slides or rolls away as soon as it moves at all.
  const double largest_step = LoadSchedule<float>(clip, particles, interactions).pinned(0) ? 1e3 : 10;
  const Region region = widened(load.region, body.cell_size);
  std::vector<Trial> found;
  const auto nearer = [&](const Trial& a, const Trial& b) {
    return std::abs(std::log(a.peak / wanted)) < std::abs(std::log(b.peak / wanted));
  };
  const auto best_found = [&] { return *std::min_element(found.begin(), found.end(), nearer); };
  const size_t usual = options.trials;
  double length = first_length(options, load, body.total_mass(), height);
  while (found.size() < usual || (miss(best_found()) >= kNearEnough && found.size() < kMostTrials)) {
    found.push_back(trials.run(body, start, region, length, 1));
    if (miss(found.back()) < (scaled ? kNearEnough : kNear)) break;
    length = next_length(found, wanted, largest_step, usual);
  }
  Trial best = best_found();
  // Too little is better than a body that is thrown away.
  if (const Bracket bracket = bracket_of(found, wanted); miss(best) >= kNearEnough && bracket.weak)
    best = *bracket.weak;
  if (!scaled) return {best.length, best.peak, static_cast<int>(found.size())};

  trials.set_done(coarse_work);
  int tried = static_cast<int>(found.size());
  for (int k = 0; k < 2; ++k) {
    best = trials.run(particles, initial_state(particles), load.region, best.length, cost);
    ++tried;
    if (miss(best) < kNear) break;
    const bool near = miss(best) < kFar;
    best = {best.length * wanted / best.peak, wanted};
    if (near) break;
  }
  return {best.length, best.peak, tried};
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
