#include "physics/body/adaptive_drivers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "physics/body/clusters.h"
#include "physics/body/thin_parts.h"

namespace pliant {
namespace {

constexpr int kSurroundings = 64;  // of a sample, that say whether it lies in a sheet, a rod or the bulk
constexpr double kPerDisk =
    1.36;  // volume per disk over its radius cubed, of dart throwing that fills space (packing 0.38)
constexpr double kTolerance = 0.01;  // of the number of drivers

/// E at which half of the volume is softer.
float median_young(const SolidSamples& samples, std::span<const float> young) {
  std::vector<int> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return young[a] < young[b]; });
  const double half = 0.5 * samples.total_volume();
  double below = 0;
  for (const int i : order)
    if ((below += samples.volume[i]) >= half) return young[i];
  return young[order.back()];
}

/// Volume of a driver with the full radius when `count` drivers are placed; none has less than one sample.
double full_driver_volume(const SolidSamples& samples, const std::vector<float>& relative, int count) {
  const double wanted = std::min<double>(count, static_cast<double>(samples.size()));
  double low = 0, high = samples.total_volume() / std::pow(kLeastRadius, 3);
  for (int iteration = 0; iteration < 60; ++iteration) {
    const double volume = 0.5 * (low + high);
    double drivers = 0;
    for (size_t i = 0; i < samples.size(); ++i)
      drivers += std::min(1.0, samples.volume[i] / (std::pow(relative[i], 3) * volume));
    (drivers > wanted ? low : high) = volume;
  }
  return high;
}

/// The disks, about `count`, whose number falls with their radius.
std::vector<int> choose_disks(const DriverOptions& options, const SolidSamples& samples,
                              const std::vector<float>& relative) {
  const double wanted = std::min<double>(options.count, static_cast<double>(samples.size()));
  double low = 0, high = 0, r = std::cbrt(full_driver_volume(samples, relative, options.count) / kPerDisk);
  std::vector<int> best;
  std::vector<float> radius(samples.size());
  const auto error = [&](const std::vector<int>& disks) {
    return std::abs(static_cast<double>(disks.size()) - wanted);
  };
  for (int trial = 0; trial < 40; ++trial) {
    for (size_t i = 0; i < samples.size(); ++i) radius[i] = static_cast<float>(r * relative[i]);
    const std::vector<int> disks = poisson_disk(samples.position, radius, options.seed);
    if (best.empty() || error(disks) < error(best)) best = disks;
    if (error(disks) <= kTolerance * wanted) break;
    (static_cast<double>(disks.size()) > wanted ? low : high) = r;
    r = high == 0 ? 1.5 * r : low == 0 ? r / 1.5 : std::sqrt(low * high);
  }
  return best;
}

}  // namespace

std::vector<float> relative_radii(const SolidSamples& samples, std::span<const float> young) {
  CHECK(young.size() == samples.size());
  std::vector<float> relative(samples.size(), 1.0f);
  if (samples.size() == 0) return relative;
  const float reference = median_young(samples, young);
  const NearestPoints tree(samples.position);
  parallel_for(
      static_cast<std::ptrdiff_t>(samples.size()),
      [&](std::ptrdiff_t i) {
        const float softness = young[i] / reference;
        if (softness >= 1) return;  // the minimum is r there, whatever the shape
        thread_local std::vector<NearestPoints::Hit> hits;
        tree.query(samples.position[i], kSurroundings, hits);
        const Vec3f variance = spread_of(samples.position, hits).value;
        const float sum = variance.sum(), bulk = sum > 0 ? std::max(0.0f, variance[0]) / sum : 0.0f;
        const float shape = std::clamp(1 + 27 * bulk, 1.0f, 10.0f);
        relative[i] = std::clamp(std::sqrt(10 * softness / shape), kLeastRadius, 1.0f);
      },
      64);
  return relative;
}

std::vector<int> poisson_disk(std::span<const Vec3f> points, std::span<const float> radius, uint64_t seed) {
  CHECK(points.size() == radius.size());
  std::vector<uint64_t> key(points.size());
  for (size_t i = 0; i < points.size(); ++i) key[i] = Random(seed, i, 1).bits();
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key[a] < key[b]; });

  const NearestPoints tree(points);
  std::vector<uint8_t> covered(points.size(), 0);
  std::vector<NearestPoints::Hit> hits;
  std::vector<int> chosen;
  for (const int i : order) {
    if (covered[i]) continue;
    chosen.push_back(i);
    tree.around(points[i], radius[i], hits);
    for (const auto& hit : hits) covered[hit.index] |= hit.distance < std::min(radius[i], radius[hit.index]);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

DrivingParticles pgas_drivers(const DriverOptions& options, const SolidSamples& samples, std::span<const float> young) {
  check_count(samples, options.count);
  const std::vector<float> relative = relative_radii(samples, young);
  const std::vector<int> disks = choose_disks(options, samples, relative);
  DrivingParticles drivers;
  for (const int i : disks) drivers.position.push_back(samples.position[i]);
  drivers.volume.resize(drivers.size());
  assign_nearest(samples, drivers);
  update_centres(samples, drivers);

  std::vector<uint8_t> sparsest;
  float largest = 0;
  for (const int i : disks) largest = std::max(largest, relative[i]);
  for (const int i : disks) sparsest.push_back(relative[i] == largest);
  // Eight to a cell where they are sparsest, so that no part has fewer.
  const auto count = static_cast<size_t>(std::count(sparsest.begin(), sparsest.end(), 1));
  const std::vector<uint8_t> rod = find_rods(samples);
  const double dx =
      cell_size_of(samples, rod, count, [&](size_t i, double) { return sparsest[drivers.sample_driver[i]] != 0; });
  lay_on_grid(options.seed, samples, rod, dx, drivers);
  return drivers;
}

SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count,
                               std::span<const float> young) {
  CHECK(young.size() == samples.size());
  SimulatedPart part = select_simulated(samples, pinned, count);
  // What is kept says what E is soft, hence how many drivers of the full radius would fill it, and that what is kept.
  int full = count;
  for (int iteration = 0; iteration < 3; ++iteration) {
    const SolidSamples kept = samples.select(part.kept);
    std::vector<float> kept_young;
    for (const int i : part.kept) kept_young.push_back(young[i]);
    const double volume = full_driver_volume(kept, relative_radii(kept, kept_young), count);
    const int next = std::max(1, static_cast<int>(std::lround(kept.total_volume() / volume)));
    if (std::abs(next - full) <= 0.01 * full) break;
    full = next;
    part = select_simulated(samples, pinned, full);
  }
  return part;
}

}  // namespace pliant
