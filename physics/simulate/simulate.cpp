#include "physics/simulate/simulate.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/simulate/loads.h"
#include "physics/laws/material.h"
#include "physics/mpm/mpm.h"

namespace pliant {
namespace {

constexpr int kMaxSubsteps = 1 << 20;  // per frame

template <class T>
void validate(const SimulateOptions& options, const BasicParticles<T>& particles,
              const BasicSimulationState<T>& start) {
  const auto require = [](bool good, const char* field, double value, const char* remedy) {
    if (!good) throw usage_error("simulate", field, "is " + std::to_string(value), remedy);
  };
  require(options.fps > 0 && std::isfinite(options.fps), "fps", options.fps, "give a positive frame rate");
  require(options.duration >= 0 && std::isfinite(options.duration), "duration", options.duration, "give seconds");
  require(options.courant > 0 && options.courant <= options.courant_cap, "courant", options.courant,
          "give a positive number below courant_cap");
  require(options.courant_cap <= 1, "courant_cap", options.courant_cap, "the scheme is unstable above 1");
  require(options.substeps >= 0 && options.substeps <= kMaxSubsteps, "substeps", options.substeps,
          "give 0 to let the time step be chosen");
  require(options.damping_time >= 0, "damping_time", options.damping_time, "give seconds, 0 = none");
  require(options.viscosity_time >= 0, "viscosity_time", options.viscosity_time, "give seconds, 0 = none");
  require(options.settle_time >= 0, "settle_time", options.settle_time, "give seconds, 0 = none");
  require(options.max_retries >= 0, "max_retries", options.max_retries, "give a number of halvings");
  require(options.gravity.allFinite(), "gravity", options.gravity.norm(), "give three finite numbers");

  const size_t n = particles.size();
  require(n > 0, "particles", 0, "seed the object first; it has no driving particle");
  CHECK(particles.volume.size() == n && particles.mass.size() == n && particles.young.size() == n &&
        particles.poisson.size() == n);
  for (size_t i = 0; i < n; ++i) {
    require(particles.volume[i] > 0 && std::isfinite(particles.volume[i]), "volume", particles.volume[i],
            "every particle needs a positive volume");
    validate_material("particle " + std::to_string(i), particles.young[i], particles.poisson[i],
                      particles.mass[i] / particles.volume[i]);
    require(particles.position[i].allFinite(), "position", particles.position[i].norm(), "positions must be finite");
  }
  CHECK_MSG(start.x.size() == n && start.v.size() == n && start.C.size() == n && start.F.size() == n,
            "state and particles differ in number");
  for (size_t i = 0; i < n; ++i)
    require(start.x[i].allFinite() && start.v[i].allFinite() && start.C[i].allFinite() && start.F[i].allFinite(),
            "state", static_cast<double>(i), "this particle's state is not finite; start from another frame");
}

/// Origin of the grid: a row of nodes lies a quarter of a cell outside the flat faces of pinned regions that cut the
/// body, because a clamp acts about that far behind the row; and on the ground.
template <class T>
Vec3d grid_origin(const BasicParticles<T>& particles, const std::vector<Interaction>& interactions, double dx) {
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  for (const Vec3<T>& x : particles.position) {
    low = low.cwiseMin(x.template cast<double>()), high = high.cwiseMax(x.template cast<double>());
  }
  Vec3d origin = 0.5 * (low + high);
  bool aligned[3] = {false, false, false};
  const auto align = [&](int axis, double plane) {
    if (aligned[axis] || plane < low[axis] - dx || plane > high[axis] + dx) return;
    // The lattice plane nearest to the middle, so that coordinates stay small.
    origin[axis] = plane + std::round((origin[axis] - plane) / dx) * dx;
    aligned[axis] = true;
  };
  constexpr double kClampOffset = kPinReach - 0.5;
  for (const Interaction& it : interactions) {
    const Region& r = it.region;
    const bool pin = it.type == InteractionType::kPin, ground = it.type == InteractionType::kGround;
    if (pin && r.kind == Region::Kind::kBox) {
      for (int a = 0; a < 3; ++a) {
        if (r.vector[a] < high[a]) align(a, r.vector[a] + kClampOffset * dx);
        if (r.point[a] > low[a]) align(a, r.point[a] - kClampOffset * dx);
      }
    } else if ((pin || ground) && r.kind == Region::Kind::kHalfSpace) {
      const Vec3d normal = r.vector.normalized();
      int axis = 0;
      normal.cwiseAbs().maxCoeff(&axis);
      if (std::abs(normal[axis]) < 0.99) continue;
      const Vec3d centre = 0.5 * (low + high);
      const double plane = centre[axis] - (centre - r.point).dot(normal) / normal[axis];
      align(axis, plane + (pin ? kClampOffset * dx / normal[axis] : 0.0));
    }
  }
  return origin;
}

/// Median of each coordinate, which strays do not move.
template <class T>
Vec3d median(const std::vector<Vec3<T>>& points) {
  Vec3d result;
  std::vector<T> along(points.size());
  for (int a = 0; a < 3; ++a) {
    for (size_t i = 0; i < points.size(); ++i) along[i] = points[i][a];
    const auto middle = along.begin() + static_cast<std::ptrdiff_t>(along.size() / 2);
    std::nth_element(along.begin(), middle, along.end());
    result[a] = static_cast<double>(*middle);
  }
  return result;
}

/// Advances one body frame by frame.
template <class T>
class Simulator {
 public:
  Simulator(const SimulateOptions& options, const BasicParticles<T>& particles,
            const std::vector<Interaction>& interactions, SimulateSummary& summary)
      : options_(options),
        particles_(particles),
        dx_(options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size)),
        schedule_(options, particles, interactions),
        solver_(particles, dx_, grid_origin(particles, interactions, dx_)),
        summary_(summary) {
    solver_.set_load_bits(schedule_.bits());
    Vec3<T> low = particles.position[0], high = low;
    for (size_t i = 0; i < particles.size(); ++i) {
      const Lame<double> law = lame<double>(particles.young[i], particles.poisson[i]);
      const double density = static_cast<double>(particles.mass[i]) / particles.volume[i];
      sound_speed_ = std::max(sound_speed_, std::sqrt((law.lambda + 2 * law.mu) / density));
      low = low.cwiseMin(particles.position[i]), high = high.cwiseMax(particles.position[i]);
    }
    diagonal_ = std::max((high - low).template cast<double>().norm(), 8 * dx_);
    // Explicit viscosity lowers the stable step of the shortest wave, whose damping ratio is xi.
    const double xi = options.viscosity_time * sound_speed_ / dx_;
    sound_speed_ /= std::sqrt(1 + xi * xi) - xi;
  }

  const LoadSchedule<T>& schedule() const { return schedule_; }

  /// Advances `state` by one frame, with a smaller time step again if it becomes unstable.
  void advance(BasicSimulationState<T>& state) {
    const double frame_time = 1 / options_.fps;
    double speed = 0;
    for (const Vec3<T>& v : state.v) speed = std::max(speed, static_cast<double>(v.norm()));
    const Vec3d centre = median(state.x);
    const Vec3d reach = Vec3d::Constant(1.5 * diagonal_ + 2 * frame_time * speed);
    const double wanted = frame_time * (sound_speed_ + speed) / (options_.courant * dx_);
    int substeps = options_.substeps > 0 ? options_.substeps : std::max(1, static_cast<int>(std::ceil(wanted)));
    for (int attempt = 0;; ++attempt) {
      if (wanted > kMaxSubsteps || attempt > options_.max_retries || substeps > kMaxSubsteps)
        throw numerical_error("simulate",
                              "frame " + std::to_string(state.frame + 1) + " stays unstable with " +
                                  std::to_string(substeps) + " substeps",
                              "lower the forces or Young's modulus, or use fewer driving particles");
      solver_.load(state, centre - reach, centre + reach);
      if (run_frame(state, frame_time / substeps, substeps)) break;
      substeps *= 2;
      ++summary_.retries;
    }
    solver_.store(state);
    ++state.frame;
    state.time = state.frame / options_.fps;
    state.substeps += substeps;

    const double dt = frame_time / substeps;
    summary_.min_dt = summary_.frames ? std::min(summary_.min_dt, dt) : dt;
    summary_.max_dt = std::max(summary_.max_dt, dt);
    summary_.substeps_of_frame.push_back(substeps);
    summary_.particle_substeps += static_cast<int64_t>(substeps) * static_cast<int64_t>(state.size());
    summary_.strays += solver_.strays();
    ++summary_.frames;
  }

 private:
  bool run_frame(const BasicSimulationState<T>& state, double dt, int substeps) {
    const double start = state.frame / options_.fps;
    return solver_.advance(
        substeps, static_cast<T>(dt), loads_, [&](int k) { schedule_.at(start + k * dt, dt, solver_, loads_); },
        [&] { return (sound_speed_ + solver_.max_speed()) * dt <= options_.courant_cap * dx_; });
  }

  SimulateOptions options_;
  const BasicParticles<T>& particles_;
  double dx_, diagonal_ = 0, sound_speed_ = 0;
  LoadSchedule<T> schedule_;
  Mpm<T> solver_;
  StepLoads<T> loads_;
  SimulateSummary& summary_;
};

template <class T>
double largest_displacement(const BasicParticles<T>& particles, const BasicSimulationState<T>& state) {
  double largest = 0;
  for (size_t i = 0; i < state.size(); ++i)
    largest = std::max(largest, static_cast<double>((state.x[i] - particles.position[i]).norm()));
  return largest;
}

/// Lets an unpinned body come to rest on the ground under gravity, strongly damped; then motion is set to zero.
template <class T>
void settle(const SimulateOptions& options, const BasicParticles<T>& particles,
            const std::vector<Interaction>& interactions, BasicSimulationState<T>& state) {
  std::vector<Interaction> world;
  for (const Interaction& it : interactions)
    if (it.type == InteractionType::kGround && it.start == 0) world.push_back(it);
  SimulateOptions damped = options;
  damped.damping_time = options.settle_time / 8;
  SimulateSummary ignored;
  Simulator<T> simulator(damped, particles, world, ignored);
  const int frames = static_cast<int>(std::ceil(options.settle_time * options.fps));
  for (int f = 0; f < frames; ++f) simulator.advance(state);
  std::fill(state.v.begin(), state.v.end(), Vec3<T>::Zero());
  std::fill(state.C.begin(), state.C.end(), Mat3<T>::Zero());
  state.time = 0, state.frame = 0, state.substeps = 0;
}

}  // namespace

template <class T>
BasicSimulateResult<T> simulate(const SimulateOptions& options, const BasicParticles<T>& particles,
                                const std::vector<Interaction>& interactions, BasicSimulationState<T> start,
                                const BasicFrameSink<T>& sink) {
  const auto begin = std::chrono::steady_clock::now();
  validate(options, particles, start);
  BasicSimulateResult<T> result;
  result.state = std::move(start);
  SimulateSummary& summary = result.summary;
  summary.mass = particles.total_mass();
  summary.cell_size = options.cell_size > 0 ? options.cell_size : static_cast<double>(particles.cell_size);
  if (!(summary.cell_size > 0))
    throw usage_error("simulate", "cell_size", "is " + std::to_string(summary.cell_size), "give metres");

  Simulator<T> simulator(options, particles, interactions, summary);
  summary.warnings = simulator.schedule().warnings();
  const bool pinned = simulator.schedule().pinned(0);
  summary.gravity_cancelled = pinned && options.gravity.norm() > 0;
  const auto deliver = [&] {
    summary.max_displacement = std::max(summary.max_displacement, largest_displacement(particles, result.state));
    result.stopped = sink && !sink(result.state);
  };
  if (result.state.frame == 0) {
    if (options.settle_time > 0 && !pinned) {
      settle(options, particles, interactions, result.state);
      summary.settle_displacement = largest_displacement(particles, result.state);
    }
    deliver();
  }
  const int frames = static_cast<int>(std::lround(options.fps * options.duration));
  while (result.state.frame < frames && !result.stopped) {
    simulator.advance(result.state);
    deliver();
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

template BasicSimulateResult<float> simulate(const SimulateOptions&, const BasicParticles<float>&,
                                             const std::vector<Interaction>&, BasicSimulationState<float>,
                                             const BasicFrameSink<float>&);
template BasicSimulateResult<double> simulate(const SimulateOptions&, const BasicParticles<double>&,
                                              const std::vector<Interaction>&, BasicSimulationState<double>,
                                              const BasicFrameSink<double>&);

}  // namespace pliant
