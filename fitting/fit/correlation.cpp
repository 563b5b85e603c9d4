#include "fitting/fit/correlation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

constexpr size_t kMostPoints = 600;  // of which pairs are looked at

/// Autocorrelation at lags 1, 2, ... before its first zero, the mean over columns of [rows, columns].
std::vector<double> in_time(std::span<const double> residuals, size_t columns) {
  const size_t rows = residuals.size() / columns;
  std::vector<double> found;
  // The mean over all columns has little chance of its own to be positive.
  for (size_t lag = 1; lag < rows; ++lag) {
    double sum = 0;
    int counted = 0;
    for (size_t c = 0; c < columns; ++c) {
      const auto at = [&](size_t k) { return residuals[k * columns + c]; };
      double variance = 0, together = 0;
      for (size_t k = 0; k < rows; ++k) variance += at(k) * at(k);
      for (size_t k = lag; k < rows; ++k) together += at(k) * at(k - lag);
      if (variance > 0) sum += together / variance, ++counted;
    }
    if (counted == 0 || sum <= 0) break;
    found.push_back(sum / counted);
  }
  return found;
}

/// Points that have errors, each's along every axis as a unit vector over the rows.
struct UnitErrors {
  std::vector<size_t> point;
  std::vector<double> row;  ///< [points, axes, rows]
};

UnitErrors unit_errors(std::span<const double> residuals, size_t points, size_t axes, size_t every) {
  const size_t rows = residuals.size() / (points * axes);
  UnitErrors out;
  for (size_t k = 0; k < points; k += every) {
    std::vector<double> of_point;
    for (size_t a = 0; a < axes; ++a) {
      double square = 0;
      for (size_t t = 0; t < rows; ++t) square += std::pow(residuals[(t * points + k) * axes + a], 2);
      for (size_t t = 0; t < rows && square > 0; ++t) of_point.push_back(residuals[(t * points + k) * axes + a] / std::sqrt(square));
    }
    if (of_point.size() != axes * rows) continue;
    out.point.push_back(k), out.row.insert(out.row.end(), of_point.begin(), of_point.end());
  }
  return out;
}

/// Median distance to the nearest other point.
double spacing_of(std::span<const Vec3f> place) {
  const std::vector<int> nearest = k_nearest(place, place, 2);
  std::vector<double> distance;
  for (size_t i = 0; i < place.size(); ++i)
    if (const int other = nearest[2 * i + 1]; other >= 0) distance.push_back((place[other] - place[i]).norm());
  if (distance.empty()) return 0;
  const auto middle = distance.begin() + static_cast<std::ptrdiff_t>(distance.size() / 2);
  std::nth_element(distance.begin(), middle, distance.end());
  return *middle;
}

}  // namespace

double correlation_factor(std::span<const double> residuals, size_t columns) {
  CHECK(columns > 0 && residuals.size() % columns == 0);
  double factor = 1;
  for (const double c : in_time(residuals, columns)) factor += 2 * c;
  return factor;
}

double correlation_factor(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes) {
  const size_t columns = place.size() * axes;
  CHECK(columns > 0 && residuals.size() % columns == 0);
  const std::vector<double> later = in_time(residuals, columns);
  double factor = 1;
  for (const double c : later) factor += 2 * c;
  const double spacing = spacing_of(place);
  if (!(spacing > 0)) return factor;
  const size_t rows = residuals.size() / columns, every = (place.size() + kMostPoints - 1) / kMostPoints;
  const UnitErrors errors = unit_errors(residuals, place.size(), axes, every);
  const size_t count = errors.point.size();
  // Of a pair, with the second `lag` rows earlier.
  const auto correlation = [&](size_t i, size_t j, size_t lag) {
    double sum = 0;
    for (size_t a = 0; a < axes; ++a) {
      const double *first = &errors.row[(i * axes + a) * rows], *second = &errors.row[(j * axes + a) * rows];
      for (size_t t = lag; t < rows; ++t) sum += first[t] * second[t - lag];
    }
    return sum / static_cast<double>(axes);
  };
  // Pairs of about the same distance, in bins one spacing wide from the nearest on.
  const auto for_pairs = [&](auto&& visit) {
    for (size_t i = 0; i < count; ++i)
      for (size_t j = i + 1; j < count; ++j)
        visit(i, j, static_cast<size_t>(std::max(0.0, std::round((place[errors.point[i]] - place[errors.point[j]]).norm() / spacing) - 1)));
  };
  std::vector<double> together, pairs;
  for_pairs([&](size_t i, size_t j, size_t bin) {
    if (bin >= pairs.size()) together.resize(bin + 1, 0.0), pairs.resize(bin + 1, 0.0);
    together[bin] += correlation(i, j, 0), pairs[bin] += 1;
  });
  size_t reach = 0;
  while (reach < pairs.size() && (pairs[reach] == 0 || together[reach] > 0)) ++reach;
  double beside = 0;
  for_pairs([&](size_t i, size_t j, size_t bin) {
    if (bin >= reach) return;
    beside += correlation(i, j, 0);
    for (size_t lag = 1; lag <= later.size(); ++lag) beside += correlation(i, j, lag) + correlation(j, i, lag);
  });
  if (count > 0) factor += 2 * beside * static_cast<double>(every) / static_cast<double>(count);
  return std::max(1.0, factor);
}

double unexplained(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes) {
  double square = 0, count = 0;
  for (const double r : residuals) square += r * r, count += r != 0;
  return std::sqrt(correlation_factor(residuals, place, axes) * square / std::max(1.0, count));
}

}  // namespace pliant
