#pragma once

#include <vector>

#include "physics/mpm/particles.h"

namespace pliant {

/// [N] outward surface element [m^2] of the body's surface that each particle stands for at rest: V times its place
/// against the mean of the particles around it, over their covariance (both weighted by splines of spacing dx) and a
/// constant.  Across a flat face lengths sum to its area within about a tenth, on sheets as thin as kThinCells too;
/// rods thinner than 3 cells get up to a quarter less, and a single layer of particles nothing.
template <class T>
std::vector<Vec3<T>> surface_elements(const BasicParticles<T>& particles, double dx);

/// [N] 1 for particles in parts thinner than 3 cells: those without a particle deep below the surface near them. Plates
/// of 2 cells are found and those of 3 are not; in between it depends on how the particles lie.
template <class T>
std::vector<uint8_t> thin_parts(const BasicParticles<T>& particles, double dx);

}  // namespace pliant
