#include "physics/body/driving_particles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/polar.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

constexpr float kThickest = 4;  // sample spacings; thicker parts are simulated as they are
constexpr float kPerCellOfRod = 8 * kThinCells * kThinCells;  // drivers of a thin rod along one cell
constexpr float kLine = 0.1f;  // ratio of variances below which points form a line

/// Principal variances (ascending) and axes of some of the points.
struct Spread {
  Vec3f value;
  Mat3f axes;
};
Spread spread_of(const std::vector<Vec3f>& points, const std::vector<NearestPoints::Hit>& chosen) {
  const float n = static_cast<float>(chosen.size());
  Vec3f mean = Vec3f::Zero();
  for (const auto& hit : chosen) mean += points[hit.index] / n;
  Mat3f covariance = Mat3f::Zero();
  for (const auto& hit : chosen) {
    const Vec3f d = points[hit.index] - mean;
    covariance += d * d.transpose() / n;
  }
  Spread spread;
  symmetric_eigen<float, 3>(covariance, spread.value, spread.axes);
  return spread;
}

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

/// Which thin samples lie in a rod: their neighbours within three thicknesses form a line, not a plane.
std::vector<uint8_t> find_rods(const SolidSamples& samples) {
  std::vector<uint8_t> rod(samples.size(), 0);
  if (samples.thickness.empty()) return rod;
  const NearestPoints tree(samples.position);
  parallel_for(static_cast<std::ptrdiff_t>(samples.size()), [&](std::ptrdiff_t i) {
    const float t = samples.thickness[i];
    if (!(t > 0) || (samples.spacing > 0 && t > kThickest * samples.spacing)) return;
    thread_local std::vector<NearestPoints::Hit> hits;
    tree.within(samples.position[i], std::max(3 * t, 2 * samples.spacing), hits);
    const Vec3f value = spread_of(samples.position, hits).value;
    rod[i] = hits.size() > 2 && value[1] < kLine * value[2];
  }, 64);
  return rod;
}

/// dx with eight drivers to a cell, thin samples counting as kThinCells dx thick: a fixed point, because dx says what
/// is thin.
template <class Keep>
double cell_size_of(const SolidSamples& samples, const std::vector<uint8_t>& rod, size_t count, Keep&& keep) {
  const auto volume_at = [&](double dx) {
    double sum = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (!keep(i, dx)) continue;
      const double t = samples.thickness.empty() ? 0 : samples.thickness[i];
      const double growth = t > 0 ? std::clamp(kThinCells * dx / t, 1.0, 1 / kThinnestPart) : 1.0;
      sum += samples.volume[i] * (rod[i] ? growth * growth : growth);
    }
    return sum;
  };
  double dx = std::cbrt(8 * samples.total_volume() / count);
  for (int iteration = 0; iteration < 200; ++iteration) {
    const double next = std::cbrt(8 * volume_at(dx) / count);
    const bool settled = std::abs(next - dx) <= 1e-7 * dx;
    dx = next;
    if (settled) break;
  }
  return dx;
}

/// Thickness and kind of the drivers from their samples, thick where most of the volume is.
void find_thickness(const SolidSamples& samples, const std::vector<uint8_t>& rod, DrivingParticles& drivers) {
  const size_t n = drivers.size();
  drivers.thickness.assign(n, 0.0f), drivers.rod.assign(n, 0);
  if (samples.thickness.empty()) return;
  std::vector<double> thin(n, 0), sum(n, 0), line(n, 0);
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!(samples.thickness[i] > 0)) continue;
    const int d = drivers.sample_driver[i];
    line[d] += rod[i] ? samples.volume[i] : 0.0f;
    thin[d] += samples.volume[i], sum[d] += static_cast<double>(samples.volume[i]) * samples.thickness[i];
  }
  for (size_t d = 0; d < n; ++d) {
    if (!(thin[d] > 0.5 * drivers.volume[d])) continue;
    drivers.thickness[d] = static_cast<float>(sum[d] / thin[d]);
    drivers.rod[d] = line[d] > 0.5 * thin[d];
  }
}

/// Offsets from the middle of a thin part that give drivers the variance of its full thickness.
struct Offsets {
  Vec3f first = Vec3f::Zero(), second = Vec3f::Zero();  // of a sheet one, of a rod two perpendicular ones
};

Offsets offsets_of(const DrivingParticles& drivers, const NearestPoints& tree, size_t d, float full) {
  thread_local std::vector<NearestPoints::Hit> hits;
  tree.query(drivers.position[d], 10, hits);
  const auto [value, axes] = spread_of(drivers.position, hits);
  if (!drivers.rod[d]) return {std::sqrt(std::max(0.0f, full * full / 12 - value[0])) * axes.col(0), Vec3f::Zero()};
  // A round rod, its drivers on a ring.
  const float radius = std::sqrt(std::max(0.0f, full * full / 8 - value[0] - value[1]));
  const Vec3f axis = axes.col(2);
  int least = 0;
  axis.cwiseAbs().minCoeff(&least);
  const Vec3f u = axis.cross(Vec3f::Unit(least)).normalized();
  // Turned along a helix, so that no direction is preferred.
  const float angle = 2.3999632f * kPerCellOfRod * drivers.position[d].dot(axis) / drivers.cell_size;
  const Vec3f v = axis.cross(u);
  return {radius * (std::cos(angle) * u + std::sin(angle) * v), radius * (std::cos(angle) * v - std::sin(angle) * u)};
}

/// Spreads the drivers of thin parts over the thickness that is simulated: to either side of a sheet, and three around
/// a rod, since a single line of drivers leaves bending of the grid unresisted.
void spread_thin_parts(uint64_t seed, const SolidSamples& samples, DrivingParticles& drivers) {
  const float full = kThinCells * drivers.cell_size;
  const size_t n = drivers.size();
  std::vector<Offsets> offsets(n);
  const auto thin = [&](size_t d) { return drivers.thickness[d] > 0 && drivers.thickness[d] < full; };
  const NearestPoints tree(drivers.position);
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t d) {
    if (thin(d)) offsets[d] = offsets_of(drivers, tree, d, full);
  }, 64);

  std::vector<int> members(n, 0);
  for (const int d : drivers.sample_driver) ++members[d];
  std::vector<int> second(n, -1), taken(n, 0);
  for (size_t d = 0; d < n; ++d) {
    if (!thin(d)) continue;
    const Vec3f middle = drivers.position[d];
    if (!drivers.rod[d]) {
      const bool below = Random(seed, d, 2).uniform() < 0.5;
      drivers.position[d] = below ? Vec3f(middle - offsets[d].first) : Vec3f(middle + offsets[d].first);
      continue;
    }
    drivers.position[d] = middle + offsets[d].first;
    if (members[d] < 3) continue;
    second[d] = static_cast<int>(drivers.size());
    for (const float side : {-1.0f, 1.0f}) {
      drivers.position.push_back(middle - 0.5f * offsets[d].first + side * 0.8660254f * offsets[d].second);
      drivers.volume.push_back(0), drivers.thickness.push_back(drivers.thickness[d]), drivers.rod.push_back(1);
    }
    drivers.volume[d] = 0;
  }
  for (size_t i = 0; i < samples.size(); ++i) {
    int& d = drivers.sample_driver[i];
    if (second[d] < 0) continue;
    const int turn = taken[d]++ % 3;
    if (turn > 0) d = second[d] + turn - 1;
    drivers.volume[d] += samples.volume[i];
  }
}

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
  const std::vector<uint8_t> rod = find_rods(samples);
  drivers.cell_size = static_cast<float>(cell_size_of(samples, rod, n, [](size_t, double) { return true; }));
  find_thickness(samples, rod, drivers);
  spread_thin_parts(options.seed, samples, drivers);
  return drivers;
}

SimulatedPart select_simulated(const SolidSamples& samples, std::span<const Region> pinned, int count) {
  constexpr double kCellsInside = 3, kCellsAway = 4;
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

  // A region may hold more than what is near the moving part, such as the pot around a stem.
  std::vector<Vec3f> moving;
  for (size_t i = 0; i < samples.size(); ++i)
    if (depth[i] < 0) moving.push_back(samples.position[i]);
  const NearestPoints tree(moving);
  std::vector<float> distance(samples.size(), 0.0f);
  parallel_for(static_cast<std::ptrdiff_t>(samples.size()), [&](std::ptrdiff_t i) {
    thread_local std::vector<NearestPoints::Hit> hits;
    if (depth[i] >= 0) tree.query(samples.position[i], 1, hits), distance[i] = hits[0].distance;
  }, 256);

  // What is kept follows from dx and dx from what is kept.
  const auto keep = [&](size_t i, double dx) { return depth[i] < kCellsInside * dx && distance[i] < kCellsAway * dx; };
  const double dx = cell_size_of(samples, find_rods(samples), count, keep);
  SimulatedPart part;
  part.cell_size = static_cast<float>(dx);
  for (size_t i = 0; i < samples.size(); ++i)
    if (keep(i, dx)) part.kept.push_back(static_cast<int>(i)), part.volume += samples.volume[i];
  return part;
}

}  // namespace pliant
