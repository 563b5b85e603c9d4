#pragma once

#include "physics/simulate/simulator.h"

namespace pliant {

struct SettleSummary {
  bool at_rest = false;     ///< false: still moving when the time was over
  double seconds = 0;       ///< simulated
  double speed = 0;         ///< m/s, largest root mean square since motion was last stopped
  double displacement = 0;  ///< m, largest distance of a particle from where it was
};

/// Interactions that shape a state of rest, for all time: weights, and pins, grounds, colliders and fingers that act
/// from the start; those that move stand where they are then.
std::vector<Interaction> resting_interactions(const std::vector<Interaction>& interactions);
/// Whether a collider or finger does not always stand there.
bool moves(const Interaction& obstacle);

/// Takes frames of `simulator` until `state` rests or `max_seconds` are over.  Whenever kinetic energy has passed a
/// maximum, where forces balance, motion is set to zero (dynamic relaxation with kinetic damping; Cundall 1976), so no
/// period has to be known.  At rest means that the root mean square speed stays below `rest_speed` [m/s].  The state
/// comes back without motion, at time 0.
template <class T>
SettleSummary settle(Simulator<T>& simulator, const BasicParticles<T>& particles, double max_seconds, double rest_speed,
                     BasicSimulationState<T>& state);

/// `options` for settling, under the gravity of an interaction that acts all the time, if there is one.  A Lagrangian
/// grid damps nothing by itself, so that waves of a few cells outlast every stop: viscosity takes them, which does not
/// change where the body rests.
template <class T>
SimulateOptions settling_options(const SimulateOptions& options, const BasicParticles<T>& particles,
                                 const std::vector<Interaction>& interactions);

/// Speed [m/s] under which a body is taken to rest: a thousandth of what it gains falling by its own size.
template <class T>
double rest_speed(const SimulateOptions& options, const BasicParticles<T>& particles);

}  // namespace pliant
