#include "app/statistics/calibration.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// The rows in an order drawn at random (Fisher and Yates 1938).
std::vector<StatedBand> shuffled(std::span<const StatedBand> rows, uint64_t seed) {
  std::vector<StatedBand> out(rows.begin(), rows.end());
  Random random(seed);
  for (size_t i = out.size(); i > 1; --i) std::swap(out[i - 1], out[random.below(i)]);
  return out;
}

std::optional<double> conformal_factor(std::span<const StatedBand> rows, double nominal) {
  std::vector<double> z;
  for (const StatedBand& row : rows) z.push_back(std::abs(row.z()));
  std::sort(z.begin(), z.end());
  // The product may lie a rounding error above the whole number that it is: 75 * 0.68 above 51.
  const auto rank = static_cast<size_t>(std::ceil((static_cast<double>(z.size()) + 1) * nominal - 1e-9));
  if (rank > z.size()) return std::nullopt;
  return z[rank - 1] / normal_half_width(nominal);
}

}  // namespace

double StatedBand::z() const {
  const double error = truth - estimate;
  return error / (error < 0 ? sigma_below : sigma_above);
}

double normal_half_width(double probability) {
  CHECK(probability > 0 && probability < 1);
  return boost::math::quantile(boost::math::normal_distribution<double>(), 0.5 * (1 + probability));
}

Coverage coverage(std::span<const StatedBand> rows, double nominal, double factor) {
  CHECK(!rows.empty());
  const double width = factor * normal_half_width(nominal);
  Coverage out;
  out.rows = static_cast<int>(rows.size());
  for (const StatedBand& row : rows) out.inside += std::abs(row.z()) <= width;
  out.share = static_cast<double>(out.inside) / out.rows;
  out.interval = clopper_pearson(out.inside, out.rows);
  out.as_stated = out.interval.contains(nominal);
  return out;
}

Calibration calibrate(std::span<const StatedBand> rows, std::span<const double> levels, uint64_t seed) {
  CHECK(rows.size() >= 8 && !levels.empty());
  const std::vector<StatedBand> mixed = shuffled(rows, seed);
  const std::span<const StatedBand> all(mixed), first = all.first(all.size() / 2), second = all.subspan(all.size() / 2);
  Calibration out;
  double log_sum = 0, factors = 0;
  for (const double nominal : levels) {
    CalibrationLevel level;
    level.nominal = nominal;
    level.stated = coverage(rows, nominal);
    level.factor = conformal_factor(first, nominal);
    level.second_half = coverage(second, nominal);
    if (level.factor) {
      level.with_factor = coverage(second, nominal, *level.factor);
    }
    if (level.factor.value_or(0) > 0) {
      log_sum += std::log(*level.factor);
      ++factors;
    }
    out.levels.push_back(level);
  }
  if (factors == 0) return out;
  out.factor = std::exp(log_sum / factors);
  for (CalibrationLevel& level : out.levels) level.with_one_factor = coverage(second, level.nominal, *out.factor);
  return out;
}

}  // namespace pliant
