#pragma once

#include "physics/simulate/simulate.h"

namespace pliant {

struct RestShapeSummary {
  int iterations = 0;
  bool converged = false;
  double residual = 0;  ///< m, largest distance of a particle from its captured position, at equilibrium
  double sag = 0;       ///< m, largest distance between the captured and the unloaded shape
  double seconds = 0;   ///< simulated
};

template <class T>
struct RestShape {
  BasicSimulationState<T> state;  ///< in equilibrium under gravity; x the captured shape but for the residual, F its
                                  ///< deformation from the unloaded shape
  std::vector<Vec3<T>> unloaded;  ///< [N] m, the shape without gravity
  RestShapeSummary summary;
};

struct RestShapeOptions {
  SimulateOptions simulate;  ///< gravity and grid of the real run
  double tolerance = 5e-4;   ///< largest residual / size of the body
  int max_iterations = 12;
  double max_seconds = 8;  ///< of settling per iteration
};

/// Inverse statics: the unloaded shape x0 from which the body, held by the pins, grounds and obstacles of
/// `interactions` as they stand at the start, comes to rest under gravity in the captured shape particles.position.
/// Fixed-point iteration x0 <- x0 - (x_eq(x0) - x_captured), each x_eq by damped settling; it converges while the sag
/// is small against the size.  An iteration that does not lessen the residual is taken back and halved.
/// Throws Error{kUsage} when no pin holds the body at the start, Error{kNumerical} when it does not come to rest.
template <class T>
RestShape<T> solve_rest_shape(const RestShapeOptions& options, const BasicParticles<T>& particles,
                              const std::vector<Interaction>& interactions);

extern template RestShape<float> solve_rest_shape(const RestShapeOptions&, const BasicParticles<float>&,
                                                  const std::vector<Interaction>&);
extern template RestShape<double> solve_rest_shape(const RestShapeOptions&, const BasicParticles<double>&,
                                                   const std::vector<Interaction>&);

}  // namespace pliant
