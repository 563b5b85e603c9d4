#include "physics/body/thin_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/polar.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "physics/body/adaptive_drivers.h"

namespace pliant {
namespace {

constexpr double kCoverThin = 0.3, kCoverThicker = 0.45;  // cells that a sample is away from its driver at most
constexpr float kThickest = 4;                            // sample spacings; thicker parts are simulated as they are
constexpr float kPerCellOfRod = 8 * kThinCells * kThinCells;  // drivers of a thin rod along one cell
constexpr float kLine = 0.1f;                                 // ratio of variances below which points form a line

}  // namespace

Mat3f covariance_of(std::span<const Vec3f> points, const std::vector<NearestPoints::Hit>& chosen) {
  const float n = static_cast<float>(chosen.size());
  Vec3f mean = Vec3f::Zero();
  for (const auto& hit : chosen) mean += points[hit.index] / n;
  Mat3f covariance = Mat3f::Zero();
  for (const auto& hit : chosen) {
    const Vec3f d = points[hit.index] - mean;
    covariance += d * d.transpose() / n;
  }
  return covariance;
}

Spread spread_of(std::span<const Vec3f> points, const std::vector<NearestPoints::Hit>& chosen) {
  Spread spread;
  symmetric_eigen<float, 3>(covariance_of(points, chosen), spread.value, spread.axes);
  return spread;
}

std::vector<uint8_t> find_rods(const SolidSamples& samples) {
  if (!samples.rod.empty()) return samples.rod;
  std::vector<uint8_t> rod(samples.size(), 0);
  if (samples.thickness.empty()) return rod;
  const NearestPoints tree(samples.position);
  parallel_for(
      static_cast<std::ptrdiff_t>(samples.size()),
      [&](std::ptrdiff_t i) {
        const float t = samples.thickness[i];
        if (!(t > 0) || (samples.spacing > 0 && t > kThickest * samples.spacing)) return;
        thread_local std::vector<NearestPoints::Hit> hits;
        tree.around(samples.position[i], std::max(3 * t, 2 * samples.spacing), hits);
        const Vec3f value = spread_of(samples.position, hits).value;
        rod[i] = hits.size() > 2 && value[1] < kLine * value[2];
      },
      64);
  return rod;
}

namespace {

/// How many times a sample counts whose part is simulated as kThinCells dx thick.
double growth_of(const SolidSamples& samples, const std::vector<uint8_t>& rod, size_t i, double dx) {
  const double t = samples.thickness.empty() ? 0 : samples.thickness[i];
  const double growth = t > 0 ? std::clamp(kThinCells * dx / t, 1.0, 1 / kThinnestPart) : 1.0;
  return rod[i] ? growth * growth : growth;
}

}  // namespace

double cell_size_of(const SolidSamples& samples, const std::vector<uint8_t>& rod, size_t count,
                    const std::function<bool(size_t, double)>& keep) {
  const auto volume_at = [&](double dx) {
    double sum = 0;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (keep(i, dx)) sum += samples.volume[i] * growth_of(samples, rod, i, dx);
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

std::vector<float> simulated_volumes(const SolidSamples& samples, const std::vector<uint8_t>& rod, double dx) {
  std::vector<float> volume(samples.size());
  for (size_t i = 0; i < samples.size(); ++i) {
    const double growth = growth_of(samples, rod, i, dx);
    const bool in_thin_rod = rod[i] && growth > 1;
    volume[i] = static_cast<float>(samples.volume[i] * (in_thin_rod ? std::max(1.0, 0.5 * growth) : growth));
  }
  return volume;
}

bool cover_samples(uint64_t seed, const SolidSamples& samples, double dx, DrivingParticles& drivers) {
  if (samples.thickness.empty()) return false;
  std::vector<Vec3f> far;
  std::vector<float> reaches;
  for (size_t i = 0; i < samples.size(); ++i) {
    const float t = samples.thickness[i];
    if (!(t > 0)) continue;  // in the bulk drivers lie close
    const float reach = static_cast<float>((t < kThinCells * dx ? kCoverThin : kCoverThicker) * dx);
    if ((samples.position[i] - drivers.position[drivers.sample_driver[i]]).norm() <= reach) continue;
    far.push_back(samples.position[i]);
    reaches.push_back(reach);
  }
  for (const int k : poisson_disk(far, reaches, seed)) {
    drivers.position.push_back(far[k]);
    drivers.volume.push_back(0);
  }
  return !far.empty();
}

namespace {

/// Thickness and kind of the drivers from their samples, thick where most of the volume is.
void find_thickness(const SolidSamples& samples, const std::vector<uint8_t>& rod, DrivingParticles& drivers) {
  const size_t n = drivers.size();
  drivers.thickness.assign(n, 0.0f);
  drivers.rod.assign(n, 0);
  if (samples.thickness.empty()) return;
  std::vector<double> thin(n, 0), sum(n, 0), line(n, 0);
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!(samples.thickness[i] > 0)) continue;
    const int d = drivers.sample_driver[i];
    line[d] += rod[i] ? samples.volume[i] : 0.0f;
    thin[d] += samples.volume[i];
    sum[d] += static_cast<double>(samples.volume[i]) * samples.thickness[i];
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
  parallel_for(
      static_cast<std::ptrdiff_t>(n),
      [&](std::ptrdiff_t d) {
        if (thin(d)) offsets[d] = offsets_of(drivers, tree, d, full);
      },
      64);

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
      drivers.volume.push_back(0);
      drivers.thickness.push_back(drivers.thickness[d]);
      drivers.rod.push_back(1);
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

void lay_on_grid(uint64_t seed, const SolidSamples& samples, const std::vector<uint8_t>& rod, double dx,
                 DrivingParticles& drivers) {
  drivers.cell_size = static_cast<float>(dx);
  find_thickness(samples, rod, drivers);
  spread_thin_parts(seed, samples, drivers);
}

}  // namespace pliant
