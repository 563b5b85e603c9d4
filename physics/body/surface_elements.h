#pragma once

#include <vector>

#include "physics/mpm/particles.h"

namespace pliant {

/// [N] outward surface element [m^2] of the body's surface that each particle stands for at rest: V times the gradient
/// of the share of space that the particles fill on a grid of spacing dx; lengths sum to the area of the surface,
/// vectors to zero.  The half of a smoothed surface that lies outside of all particles counts with the inner half.
template <class T>
std::vector<Vec3<T>> surface_elements(const BasicParticles<T>& particles, double dx);

/// [N] 1 for particles in parts thinner than 3 cells: those that lie in no cube of 3 x 3 x 3 cells that are filled.
template <class T>
std::vector<uint8_t> thin_parts(const std::vector<Vec3<T>>& position, const std::vector<T>& volume, double dx);

}  // namespace pliant
