#include "fitting/fit/correlation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

constexpr size_t kMostPoints = 1000;  // of which pairs are looked at

/// Median distance to the nearest other point.
double spacing_of(std::span<const Vec3f> place) {
  const std::vector<int> nearest = k_nearest(place, place, 2);
  std::vector<double> distance;
  for (size_t i = 0; i < place.size(); ++i)
    if (const int other = nearest[2 * i + 1]; other >= 0) distance.push_back((place[other] - place[i]).norm());
  if (distance.empty()) return 0;
  std::nth_element(distance.begin(), distance.begin() + distance.size() / 2, distance.end());
  return distance[distance.size() / 2];
}

}  // namespace

double correlation_factor(std::span<const double> residuals, size_t columns) {
  CHECK(columns > 0 && residuals.size() % columns == 0);
  const size_t rows = residuals.size() / columns;
  double factor = 1;
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
    factor += 2 * sum / counted;
  }
  return factor;
}

double neighbour_factor(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes) {
  const size_t columns = place.size() * axes;
  CHECK(columns > 0 && residuals.size() % columns == 0);
  const size_t rows = residuals.size() / columns, every = (place.size() + kMostPoints - 1) / kMostPoints;
  const double spacing = spacing_of(place);
  if (!(spacing > 0)) return 1;
  // Each point's errors along an axis, as a unit vector over the rows; points without errors have no say.
  std::vector<size_t> point;
  std::vector<double> unit;  // [points looked at, axes, rows]
  for (size_t k = 0; k < place.size(); k += every) {
    std::vector<double> of_point;
    for (size_t a = 0; a < axes; ++a) {
      double square = 0;
      for (size_t t = 0; t < rows; ++t) square += std::pow(residuals[t * columns + k * axes + a], 2);
      for (size_t t = 0; t < rows && square > 0; ++t) of_point.push_back(residuals[t * columns + k * axes + a] / std::sqrt(square));
    }
    if (of_point.size() != axes * rows) continue;
    point.push_back(k), unit.insert(unit.end(), of_point.begin(), of_point.end());
  }
  // Sums over all pairs of about the same distance.
  std::vector<double> correlation, pairs;
  for (size_t i = 0; i < point.size(); ++i)
    for (size_t j = i + 1; j < point.size(); ++j) {
      const size_t bin = static_cast<size_t>(std::max(0.0, std::round((place[point[i]] - place[point[j]]).norm() / spacing) - 1));
      if (bin >= pairs.size()) correlation.resize(bin + 1, 0.0), pairs.resize(bin + 1, 0.0);
      const double* a = &unit[i * axes * rows];
      const double* b = &unit[j * axes * rows];
      double together = 0;
      for (size_t t = 0; t < axes * rows; ++t) together += a[t] * b[t];
      correlation[bin] += together / static_cast<double>(axes), pairs[bin] += 1;
    }
  double factor = 1;
  for (size_t bin = 0; bin < pairs.size(); ++bin) {
    if (pairs[bin] == 0) continue;
    if (correlation[bin] <= 0) break;
    factor += 2 * correlation[bin] * static_cast<double>(every) / static_cast<double>(point.size());
  }
  return factor;
}

double unexplained(std::span<const double> residuals, std::span<const Vec3f> place, size_t axes) {
  double square = 0, count = 0;
  for (const double r : residuals) square += r * r, count += r != 0;
  const double wider = correlation_factor(residuals, place.size() * axes) * neighbour_factor(residuals, place, axes);
  return std::sqrt(wider * square / std::max(1.0, count));
}

}  // namespace pliant
