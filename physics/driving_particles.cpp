#include "physics/driving_particles.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Position along the Morton curve of x in [0, 1)^3, 20 bits an axis.
uint64_t morton_key(const Vec3d& x) {
  uint64_t key = 0;
  for (int a = 0; a < 3; ++a) {
    const uint64_t cell = static_cast<uint64_t>(std::clamp(x[a], 0.0, 0.999999) * (1 << 20));
    for (int bit = 0; bit < 20; ++bit) key |= (cell >> bit & 1) << (3 * bit + a);
  }
  return key;
}

/// Samples in the order of a space-filling curve whose origin the seed moves.
std::vector<int> curve_order(const SolidSamples& samples, uint64_t seed) {
  Box box;
  for (const Vec3f& x : samples.position) box.add(x);
  const double side = std::max(1e-30, static_cast<double>(box.size().maxCoeff())) * 2;
  Random random(seed);
  const Vec3d shift(0.5 * random.uniform(), 0.5 * random.uniform(), 0.5 * random.uniform());
  std::vector<uint64_t> key(samples.size());
  for (size_t i = 0; i < samples.size(); ++i)
    key[i] = morton_key((samples.position[i] - box.low).cast<double>() / side + shift);
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key[a] < key[b]; });
  return order;
}

/// Volume-weighted centroids and volumes of the clusters, summed in the order of the samples.
void update_centres(const SolidSamples& samples, DrivingParticles& drivers) {
  std::vector<Vec3d> sum(drivers.size(), Vec3d::Zero());
  std::vector<double> volume(drivers.size(), 0);
  for (size_t i = 0; i < samples.size(); ++i) {
    const int d = drivers.sample_driver[i];
    sum[d] += static_cast<double>(samples.volume[i]) * samples.position[i].cast<double>();
    volume[d] += samples.volume[i];
  }
  for (size_t d = 0; d < drivers.size(); ++d) {
    if (!(volume[d] > 0)) continue;
    drivers.position[d] = (sum[d] / volume[d]).cast<float>();
    drivers.volume[d] = static_cast<float>(volume[d]);
  }
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
    --members[drivers.sample_driver[i]], ++members[d];
    drivers.sample_driver[i] = static_cast<int>(d);
  }
}

float cell_size_of(double volume, size_t count) { return static_cast<float>(std::cbrt(8 * volume / count)); }

}  // namespace

DrivingParticles kmeans_drivers(const DriverOptions& options, const SolidSamples& samples) {
  if (samples.size() == 0)
    throw usage_error("seed", "samples", "there are none", "choose an object with visible Gaussians");
  if (options.count < 1)
    throw usage_error("seed", "count", "is " + std::to_string(options.count), "give a positive number of particles");
  const size_t m = samples.size(), n = std::min(m, static_cast<size_t>(options.count));

  DrivingParticles drivers;
  drivers.position.resize(n), drivers.volume.resize(n), drivers.sample_driver.resize(m);
  const std::vector<int> order = curve_order(samples, options.seed);
  for (size_t k = 0; k < m; ++k) drivers.sample_driver[order[k]] = static_cast<int>(k * n / m);
  update_centres(samples, drivers);
  for (int iteration = 0; iteration < options.iterations && n < m; ++iteration) {
    const NearestPoints tree(drivers.position);
    parallel_for(static_cast<std::ptrdiff_t>(m), [&](std::ptrdiff_t i) {
      thread_local std::vector<NearestPoints::Hit> hits;
      tree.query(samples.position[i], 1, hits);
      drivers.sample_driver[i] = hits[0].index;
    }, 256);
    fill_empty(samples, drivers);
    update_centres(samples, drivers);
  }
  drivers.cell_size = cell_size_of(samples.total_volume(), n);
  return drivers;
}

SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count) {
  constexpr double kCellsInside = 3;
  if (samples.size() == 0)
    throw usage_error("seed", "samples", "there are none", "choose an object with visible Gaussians");
  if (count < 1) throw usage_error("seed", "count", "is " + std::to_string(count), "give a positive number of particles");
  std::vector<double> depth(samples.size(), -INFINITY);
  double outside = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    for (const Region& region : pinned)
      depth[i] = std::max(depth[i], -region.signed_distance(samples.position[i].cast<double>()));
    if (depth[i] < 0) outside += samples.volume[i];
  }
  if (!(outside > 0))
    throw usage_error("seed", "pinned", "covers the whole object", "shrink the pinned regions so that something can move");

  // The kept volume grows with dx and dx with the kept volume: from above this falls to the largest fixed point.
  SimulatedPart part;
  double dx = cell_size_of(samples.total_volume(), count);
  for (int iteration = 0; iteration < 100; ++iteration) {
    part.volume = 0;
    for (size_t i = 0; i < samples.size(); ++i)
      if (depth[i] < kCellsInside * dx) part.volume += samples.volume[i];
    const double next = cell_size_of(part.volume, count);
    if (next == dx) break;
    dx = next;
  }
  for (size_t i = 0; i < samples.size(); ++i)
    if (depth[i] < kCellsInside * dx) part.kept.push_back(static_cast<int>(i));
  part.volume = 0;
  for (const int i : part.kept) part.volume += samples.volume[i];
  part.cell_size = cell_size_of(part.volume, count);
  return part;
}

}  // namespace pliant
