#include "physics/body/driving_particles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/morton.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "physics/body/clusters.h"
#include "physics/body/thin_parts.h"

namespace pliant {
namespace {

constexpr int kCoveringRounds = 3;

/// Samples in the order of a space-filling curve whose origin the seed moves.
std::vector<int> curve_order(const SolidSamples& samples, uint64_t seed) {
  Random random(seed);
  const Vec3d shift(0.5 * random.uniform(), 0.5 * random.uniform(), 0.5 * random.uniform());
  return morton_order(samples.position, shift);
}

/// Gives every empty cluster the sample that lies farthest from the centre of a cluster with others.
void fill_empty(const SolidSamples& samples, DrivingParticles& drivers) {
  std::vector<int> members(drivers.size(), 0);
  for (const int d : drivers.sample_driver) ++members[d];
  if (std::find(members.begin(), members.end(), 0) == members.end()) return;
  std::vector<float> distance(samples.size());
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  for (size_t i = 0; i < samples.size(); ++i)
    distance[i] = (samples.position[i] - drivers.position[drivers.sample_driver[i]]).squaredNorm();
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return distance[a] > distance[b]; });
  size_t next = 0;
  for (size_t d = 0; d < drivers.size(); ++d) {
    if (members[d] > 0) continue;
    while (members[drivers.sample_driver[order[next]]] < 2) ++next;
    const int i = order[next++];
    --members[drivers.sample_driver[i]];
    ++members[d];
    drivers.sample_driver[i] = static_cast<int>(d);
  }
}

}  // namespace

DrivingParticles kmeans_drivers(const DriverOptions& options, const SolidSamples& samples) {
  check_count(samples, options.count);
  const size_t m = samples.size(), n = std::min(m, static_cast<size_t>(options.count));

  DrivingParticles drivers;
  drivers.position.resize(n);
  drivers.volume.resize(n);
  drivers.sample_driver.resize(m);
  // Clustered by what the grid will see of them, so that a leaf gets as many drivers to a cell as a trunk.
  SolidSamples seen = samples;
  const std::vector<uint8_t> rod = find_rods(samples);
  const double dx = cell_size_of(samples, rod, n, [](size_t, double) { return true; });
  seen.volume = simulated_volumes(samples, rod, dx);
  std::vector<double> up_to(m + 1, 0);
  const std::vector<int> order = curve_order(samples, options.seed);
  for (size_t k = 0; k < m; ++k) up_to[k + 1] = up_to[k] + seen.volume[order[k]];
  for (size_t k = 0; k < m; ++k) {
    const double middle = 0.5 * (up_to[k] + up_to[k + 1]) / up_to[m];
    drivers.sample_driver[order[k]] =
        n == m ? static_cast<int>(k) : std::min(static_cast<int>(middle * n), static_cast<int>(n) - 1);
  }
  update_centres(seen, drivers);
  fill_empty(samples, drivers);
  update_centres(seen, drivers);
  for (int iteration = 0; iteration < options.iterations && n < m; ++iteration) {
    assign_nearest(samples, drivers);
    fill_empty(samples, drivers);
    update_centres(seen, drivers);
  }
  for (int round = 0; round < kCoveringRounds && n < m; ++round) {
    if (!cover_samples(options.seed, samples, dx, drivers)) break;
    assign_nearest(samples, drivers);
    fill_empty(samples, drivers);
    update_centres(seen, drivers);
  }
  update_centres(samples, drivers);
  lay_on_grid(options.seed, samples, rod, dx, drivers);
  return drivers;
}

SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count) {
  constexpr double kCellsInside = 3, kCellsAway = 4;
  check_count(samples, count);
  std::vector<double> depth(samples.size(), -INFINITY);
  double outside = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    for (const Region& region : pinned)
      depth[i] = std::max(depth[i], -region.signed_distance(samples.position[i].cast<double>()));
    if (depth[i] < 0) outside += samples.volume[i];
  }
  if (!(outside > 0))
    throw usage_error("seed", "pinned", "covers the whole object",
                      "shrink the pinned regions so that something can move");

  // A region may hold more than what is near the moving part, such as the pot around a stem.
  std::vector<Vec3f> moving;
  for (size_t i = 0; i < samples.size(); ++i)
    if (depth[i] < 0) moving.push_back(samples.position[i]);
  const NearestPoints tree(moving);
  std::vector<float> distance(samples.size(), 0.0f);
  parallel_for(
      static_cast<std::ptrdiff_t>(samples.size()),
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        if (depth[i] >= 0) {
          tree.query(samples.position[i], 1, hits);
          distance[i] = hits[0].distance;
        }
      },
      256);

  // What is kept follows from dx and dx from what is kept.
  const auto keep = [&](size_t i, double dx) { return depth[i] < kCellsInside * dx && distance[i] < kCellsAway * dx; };
  const double dx = cell_size_of(samples, find_rods(samples), count, keep);
  SimulatedPart part;
  part.cell_size = static_cast<float>(dx);
  for (size_t i = 0; i < samples.size(); ++i)
    if (keep(i, dx)) {
      part.kept.push_back(static_cast<int>(i));
      part.volume += samples.volume[i];
    }
  return part;
}

}  // namespace pliant
