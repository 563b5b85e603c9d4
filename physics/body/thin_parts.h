#pragma once

#include <functional>
#include <vector>

#include "gaussians/base/nearest.h"
#include "physics/body/driving_particles.h"

namespace pliant {

/// Principal variances (ascending) and axes of some of the points.
struct Spread {
  Vec3f value;
  Mat3f axes;
};
Spread spread_of(const std::vector<Vec3f>& points, const std::vector<NearestPoints::Hit>& chosen);

/// Which thin samples lie in a rod: their neighbours within three thicknesses form a line, not a plane.
std::vector<uint8_t> find_rods(const SolidSamples& samples);

/// dx with eight of `count` drivers to a cell of the samples that keep(i, dx), thin ones counting as kThinCells dx
/// thick: a fixed point, because dx says what is thin.
double cell_size_of(const SolidSamples& samples, const std::vector<uint8_t>& rod, size_t count,
                    const std::function<bool(size_t, double)>& keep);

/// Lays drivers, whose samples, centroids and volumes are known, on a grid: dx with eight drivers to a cell where they
/// are `sparsest` (empty = everywhere), so that no part has fewer; then thickness and kind of every driver, and those
/// of parts thinner than kThinCells dx spread across that thickness, three for one in rods, so that the grid feels them
/// bend.
void lay_on_grid(uint64_t seed, const SolidSamples& samples, const std::vector<uint8_t>& sparsest,
                 DrivingParticles& drivers);

}  // namespace pliant
