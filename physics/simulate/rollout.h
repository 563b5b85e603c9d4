#pragma once

#include <functional>
#include <vector>

#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/simulate/simulate.h"

namespace pliant {

struct RolloutOptions {
  SimulateOptions simulate;           ///< `substeps` 0 = chosen once, from the start; the same in every frame
  size_t memory = size_t{512} << 20;  ///< bytes for the substeps of a frame; beyond it they are computed once more
  int gradient_window = 0;            ///< frames; see `rollout_adjoint`; 0 = all
  int gradient_substeps = 0;          ///< last ones of each frame, see there; 0 = all
};

/// States at all frame borders, the start included, and the time step between them.
template <class T>
struct Rollout {
  std::vector<BasicSimulationState<T>> frames;
  int substeps = 0;  ///< per frame
  SimulateSummary summary;
};

/// Derivatives of L by all that a roll-out starts from.
template <class T>
struct RolloutGradient {
  struct ByMaterial {
    double damping_time = 0, viscosity_time = 0;  ///< 0 where they are off
    BranchGradient<double> branch = {};           ///< viscoelastic
  };

  StateGradient<T> start;          ///< x, v, C, F, memory of the first state
  std::vector<T> young, poisson;   ///< [N]
  std::vector<T> mass;             ///< [N] at fixed volume, weights apart; by density: times the volume
  std::vector<Vec3d> interaction;  ///< [interactions] by `vector`: force, impulse, acceleration, wind, gravity
  std::vector<double> weight;      ///< [interactions] by `mass` of weights, 1/kg; 0 for all others
  Vec3d gravity = Vec3d::Zero();   ///< of the options
  double damping_time = 0, viscosity_time = 0;  ///< of the options; 0 where they are off
  std::vector<ByMaterial> material;             ///< [materials]

  double forward_seconds = 0, reverse_seconds = 0;  ///< recomputation of states, and the way back
  size_t bytes = 0;                                 ///< largest memory of states, substeps and derivatives
};

/// Adds dL/d(state of frame k of the roll-out) to its argument.
template <class T>
using FrameCotangent = std::function<void(int k, StateGradient<T>& gradient)>;

/// `simulate` with a fixed time step and nothing asleep, bit for bit, which keeps all frames.
template <class T>
Rollout<T> rollout(const RolloutOptions& options, const BasicParticles<T>& particles,
                   const std::vector<Interaction>& interactions, const BasicSimulationState<T>& start);

/// Exact derivatives of L(frames) by reverse mode.  `cotangent` is called for every frame, last one first, from one
/// thread.  The substeps of a frame are computed again and kept; if they need more than `options.memory`, only some,
/// from which the others follow at the cost of one more forward run: same result bit for bit.
/// With a gradient window of w frames, the state at every w-th frame counts as given, so that the loss of a frame
/// reaches at most the w frames before it; 1 = only the frame itself.  With g gradient substeps, the state before the
/// last g of each frame counts as given.  Equal for any number of threads.
/// Held constant: the time step, which nodes touch what, and the places of strays.
template <class T>
RolloutGradient<T> rollout_adjoint(const RolloutOptions& options, const BasicParticles<T>& particles,
                                   const std::vector<Interaction>& interactions, const Rollout<T>& rollout,
                                   const FrameCotangent<T>& cotangent);

#define PLIANT_ROLLOUT(T)                                                                                              \
  extern template Rollout<T> rollout(const RolloutOptions&, const BasicParticles<T>&, const std::vector<Interaction>&, \
                                     const BasicSimulationState<T>&);                                                  \
  extern template RolloutGradient<T> rollout_adjoint(const RolloutOptions&, const BasicParticles<T>&,                  \
                                                     const std::vector<Interaction>&, const Rollout<T>&,               \
                                                     const FrameCotangent<T>&);
PLIANT_ROLLOUT(float)
PLIANT_ROLLOUT(double)
#undef PLIANT_ROLLOUT

}  // namespace pliant
