#pragma once

#include <functional>
#include <span>
#include <vector>

#include "gaussians/base/nearest.h"
#include "physics/body/driving_particles.h"

namespace pliant {

/// Covariance of some of the points.
Mat3f covariance_of(std::span<const Vec3f> points, const std::vector<NearestPoints::Hit>& chosen);

/// Principal variances (ascending) and axes of some of the points.
struct Spread {
  Vec3f value;
  Mat3f axes;
};
Spread spread_of(std::span<const Vec3f> points, const std::vector<NearestPoints::Hit>& chosen);

/// Which thin samples lie in a rod: their neighbours within three thicknesses form a line, not a plane.  The functions
/// below take it as `rod`.
std::vector<uint8_t> find_rods(const SolidSamples& samples);

/// dx with eight of `count` drivers to a cell of the samples that keep(i, dx), thin ones counting as kThinCells dx
/// thick: a fixed point, because dx says what is thin.
double cell_size_of(const SolidSamples& samples, const std::vector<uint8_t>& rod, size_t count,
                    const std::function<bool(size_t, double)>& keep);

/// [M] volumes of the samples as drivers are spread over them: thin parts count as kThinCells dx thick, rods half as
/// much, because three drivers stand for one there.
std::vector<float> simulated_volumes(const SolidSamples& samples, const std::vector<uint8_t>& rod, double dx);

/// Adds drivers until every sample of a part whose thickness is known is within 0.45 dx of one, and those of parts
/// thinner than kThinCells dx within 0.3 dx, so that neighbours along a sheet or rod are about 0.6 dx apart at most.
/// False where nothing was missing.
bool cover_samples(uint64_t seed, const SolidSamples& samples, double dx, DrivingParticles& drivers);

/// Lays drivers, whose samples, centroids and volumes are known, on a grid of cells of dx: thickness and kind of every
/// driver, and those of parts thinner than kThinCells dx spread across that thickness, three for one in rods, so that
/// the grid feels them bend.
void lay_on_grid(uint64_t seed, const SolidSamples& samples, const std::vector<uint8_t>& rod, double dx,
                 DrivingParticles& drivers);

}  // namespace pliant
