#pragma once

#include "physics/mpm/particles.h"

namespace pliant {

/// 1/2 sum m (|v|^2 + dx^2/4 |C|^2) [J]: what quadratic B-splines carry of an affine velocity field (Jiang et al.
/// 2015).
template <class T>
double kinetic_energy(const BasicParticles<T>& particles, const BasicSimulationState<T>& state);

/// sum V Psi(F) [J].
template <class T>
double elastic_energy(const BasicParticles<T>& particles, const BasicSimulationState<T>& state);

}  // namespace pliant
