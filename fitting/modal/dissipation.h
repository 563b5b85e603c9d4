#pragma once

#include "fitting/objective/motion.h"

namespace pliant {

/// How fast a free swing loses its amplitude, as rates [1/s].
struct Dissipation {
  double whole = 0;      ///< by all losses together
  double transfers = 0;  ///< by the solver's transfers alone: what `damping_time` does not account for
};

/// By the balance of energy over the motion, on which nothing but pins acts: a drag that lowers amplitudes as exp(-t /
/// T) takes 4 / T times the kinetic energy in a second.  Coarse grids lose more than fine ones, so what was fitted as
/// damping_time on one of them does not hold on another, whole - transfers of the other does.  Zero when nothing moves.
Dissipation dissipation_of(const Motion<float>& motion);

/// `damping_time` [s] with which the motion loses as much as `whole_time` [s] says, on its grid; 0 = none, also when
/// the transfers alone take more.
double damping_time_beside_transfers(Motion<float> motion, double whole_time);

}  // namespace pliant
