#include "physics/simulate/rest_shape.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/simulate/settle.h"

namespace pliant {
namespace {

Error too_soft(const std::string& problem) {
  return numerical_error("rest shape", problem, "raise Young's modulus, or use --rest-shape captured");
}

template <class T>
SettleSummary settle_under_gravity(Simulator<T>& simulator, const BasicParticles<T>& particles, double max_seconds,
                                   double rest_speed, BasicSimulationState<T>& state) {
  SettleSummary settled;
  try {
    settled = settle(simulator, particles, max_seconds, rest_speed, state);
  } catch (const Error& error) {
    if (error.failure != Failure::kNumerical) throw;
    throw too_soft("the body becomes unstable while it settles under gravity");
  }
  if (!settled.at_rest)
    throw too_soft("the body does not come to rest under gravity within " + std::to_string(max_seconds) + " s");
  return settled;
}

}  // namespace

template <class T>
RestShape<T> solve_rest_shape(const RestShapeOptions& options, const BasicParticles<T>& particles,
                              const std::vector<Interaction>& interactions) {
  SimulateOptions loaded = options.simulate;
  loaded.rest_shape = RestShapeMode::kSolve;  // all of gravity acts
  loaded.grid = GridKind::kEulerian;          // the shape at rest is what is sought
  SimulateSummary ignored;
  // Weights are hung on the body afterwards.
  std::vector<Interaction> world = resting_interactions(interactions);
  std::erase_if(world, [](const Interaction& it) { return it.type == InteractionType::kWeight; });
  Simulator<T> simulator(loaded, particles, world, ignored);
  if (!simulator.schedule().pinned(0))
    throw usage_error("rest shape", "pin", "fixes nothing at time 0", "pin the body, or let it settle instead");

  const size_t n = particles.size();
  Vec3<T> low = particles.position[0], high = low;
  for (const Vec3<T>& x : particles.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double size = static_cast<double>((high - low).norm());
  // Settling has to be finer than the residual that is asked for.
  const double speed = 0.2 * rest_speed(loaded, particles);

  RestShape<T> best;
  std::vector<Vec3<T>> unloaded = particles.position;
  RestShapeSummary summary;
  double damping = 1;
  for (summary.iterations = 1; summary.iterations <= options.max_iterations; ++summary.iterations) {
    BasicSimulationState<T> state = initial_state(particles);
    state.x = unloaded;
    summary.seconds += settle_under_gravity(simulator, particles, options.max_seconds, speed, state).seconds;
    double residual = 0;
    for (size_t i = 0; i < n; ++i)
      residual = std::max(residual, static_cast<double>((state.x[i] - particles.position[i]).norm()));
    if (best.unloaded.empty() || residual < summary.residual) {
      best.unloaded = unloaded;
      best.state = std::move(state);
      summary.residual = residual;
    } else {
      damping *= 0.5;
    }
    summary.converged = summary.residual <= options.tolerance * size;
    if (summary.converged) break;
    for (size_t i = 0; i < n; ++i)
      unloaded[i] = best.unloaded[i] - static_cast<T>(damping) * (best.state.x[i] - particles.position[i]);
  }
  summary.iterations = std::min(summary.iterations, options.max_iterations);
  for (size_t i = 0; i < n; ++i)
    summary.sag = std::max(summary.sag, static_cast<double>((best.unloaded[i] - particles.position[i]).norm()));
  best.summary = summary;
  return best;
}

template RestShape<float> solve_rest_shape(const RestShapeOptions&, const BasicParticles<float>&,
                                           const std::vector<Interaction>&);
template RestShape<double> solve_rest_shape(const RestShapeOptions&, const BasicParticles<double>&,
                                            const std::vector<Interaction>&);

}  // namespace pliant
