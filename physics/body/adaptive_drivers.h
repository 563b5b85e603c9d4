#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/body/driving_particles.h"

namespace pliant {

// Driving particles by physical-geometric adaptive sampling (PGAS; Zhao et al. 2024, "Sim Anything", arXiv 2411.12789):
// Poisson-disk sampling of the solid samples with a radius that is smaller where the material is soft and the body
// bulky,
//   r_hat = min(r, k sqrt(E / (E_ref K_hat)) r),  k = sqrt(10),  K_hat = clamp(1 + 27 l3 / (l1 + l2 + l3), 1, 10),
// l1 >= l2 >= l3 the principal variances of the samples around.  The paper clamps K = l3 / (l1 + l2 + l3) itself, which
// is at most 1/3, so that its K_hat is always 1; here K_hat runs from 1 in sheets and rods to 10 in the bulk.  It
// leaves E without a unit; here E_ref is the median over the samples, by volume.  Since K_hat <= k^2, a uniform E gives
// the radius r everywhere.

/// r_hat / r of every sample [M] for E = `young` [M, Pa], no less than kLeastRadius.
std::vector<float> relative_radii(const SolidSamples& samples, std::span<const float> young);

/// One grid serves the whole body: parts denser than this gain nothing from it and take their particles from the
/// others.
constexpr float kLeastRadius = 0.4f;

/// Chosen points (indices, ascending) by dart throwing in random order: no two are nearer than the smaller of their
/// radii, and every point has a chosen one nearer than its radius.
std::vector<int> poisson_disk(std::span<const Vec3f> points, std::span<const float> radius, uint64_t seed);

/// Drivers by PGAS, `options.count` of them within about one per cent: r is found by bisection.  A driver stands at the
/// centroid of the samples that are nearest to the chosen one.  dx is that of the parts with the full radius, so that
/// eight drivers lie in a cell there and more elsewhere.  Otherwise as kmeans_drivers.
DrivingParticles pgas_drivers(const DriverOptions& options, const SolidSamples& samples, std::span<const float> young);

/// What is simulated when drivers are placed by PGAS: as select_simulated, with the larger cells that these ask for.
SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count,
                               std::span<const float> young);

}  // namespace pliant
