#include "physics/simulate/simulate.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/laws/material.h"
#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

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
  require(options.substeps >= 0 && options.substeps <= kMaxSubstepsOfFrame, "substeps", options.substeps,
          "give 0 to let the time step be chosen");
  require(options.damping_time >= 0, "damping_time", options.damping_time, "give seconds, 0 = none");
  require(options.viscosity_time >= 0, "viscosity_time", options.viscosity_time, "give seconds, 0 = none");
  require(options.flip_time >= 0, "flip_time", options.flip_time, "give seconds, 0 = APIC");
  require(options.sleep_speed >= 0, "sleep_speed", options.sleep_speed, "give metres per second, 0 = off");
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
