#pragma once

#include <vector>

#include "physics/mpm/particles.h"

namespace pliant {

/// [N] outward surface element [m^2] of the body's surface that each particle stands for at rest: V / ln 2 times the
/// gradient of the logarithm of the share of space that the particles fill on a grid of spacing dx; across a flat face
/// lengths sum to its area.
template <class T>
std::vector<Vec3<T>> surface_elements(const BasicParticles<T>& particles, double dx);

/// [N] 1 for particles in parts thinner than 3 cells: those without a particle deep below the surface near them. Plates
/// of 2 cells are found and those of 3 are not; in between it depends on how the particles lie.
template <class T>
std::vector<uint8_t> thin_parts(const BasicParticles<T>& particles, double dx);

}  // namespace pliant
