#include "fitting/solve/correlation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/quantile.h"

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
      if (variance > 0) {
        sum += together / variance;
        ++counted;
      }
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
      for (size_t t = 0; t < rows && square > 0; ++t)
        of_point.push_back(residuals[(t * points + k) * axes + a] / std::sqrt(square));
    }
    if (of_point.size() != axes * rows) continue;
    out.point.push_back(k);
    out.row.insert(out.row.end(), of_point.begin(), of_point.end());
  }
  return out;
}

/// Median distance to the nearest other point.
double spacing_of(std::span<const Vec3f> place) {
  const std::vector<int> nearest = k_nearest(place, place, 2);
  std::vector<double> distance;
  for (size_t i = 0; i < place.size(); ++i)
    if (const int other = nearest[2 * i + 1]; other >= 0) distance.push_back((place[other] - place[i]).norm());
  return quantile(std::move(distance), 0.5);
}

}  // namespace

ErrorCorrelation::ErrorCorrelation(std::span<const double> errors, std::span<const Vec3f> place, size_t axes)
    : place_(place.begin(), place.end()), axes_(axes) {
  const size_t columns = place.size() * axes;
  CHECK(columns > 0 && errors.size() % columns == 0);
  rows_ = errors.size() / columns;
  for (size_t c = 0; c < columns; ++c) {
    double square = 0, count = 0;
    for (size_t t = 0; t < rows_; ++t) {
      square += std::pow(errors[t * columns + c], 2);
      count += errors[t * columns + c] != 0;
    }
    size_.push_back(std::sqrt(square / std::max(1.0, count)));
  }
  own_ = in_time(errors, columns);
  own_.insert(own_.begin(), 1.0);
  for (size_t lag = 1; lag < own_.size(); ++lag) factor_ += 2 * own_[lag];
  spacing_ = spacing_of(place);
  if (!(spacing_ > 0)) return;

  const size_t every = (place.size() + kMostPoints - 1) / kMostPoints;
  const UnitErrors units = unit_errors(errors, place.size(), axes, every);
  const size_t count = units.point.size();
  // Of a pair, with the second `lag` rows earlier.
  const auto correlation = [&](size_t i, size_t j, size_t lag) {
    double sum = 0;
    for (size_t a = 0; a < axes; ++a) {
      const double *first = &units.row[(i * axes + a) * rows_], *second = &units.row[(j * axes + a) * rows_];
      for (size_t t = lag; t < rows_; ++t) sum += first[t] * second[t - lag];
    }
    return sum / static_cast<double>(axes);
  };
  const auto for_pairs = [&](auto&& visit) {
    for (size_t i = 0; i < count; ++i)
      for (size_t j = i + 1; j < count; ++j) visit(i, j, bin(units.point[i], units.point[j]));
  };
  std::vector<double> together, pairs;
  for_pairs([&](size_t i, size_t j, size_t b) {
    if (b >= pairs.size()) {
      together.resize(b + 1, 0.0);
      pairs.resize(b + 1, 0.0);
    }
    together[b] += correlation(i, j, 0);
    pairs[b] += 1;
  });
  size_t reach = 0;
  while (reach < pairs.size() && (pairs[reach] == 0 || together[reach] > 0)) ++reach;
  with_.assign(reach, std::vector<double>(own_.size(), 0.0));
  for_pairs([&](size_t i, size_t j, size_t b) {
    if (b >= reach) return;
    with_[b][0] += correlation(i, j, 0) / pairs[b];
    for (size_t lag = 1; lag < own_.size(); ++lag)
      with_[b][lag] += (correlation(i, j, lag) + correlation(j, i, lag)) / (2 * pairs[b]);
  });
  double beside = 0;
  for (size_t b = 0; b < reach; ++b)
    for (size_t lag = 0; lag < own_.size(); ++lag) beside += pairs[b] * with_[b][lag] * (lag > 0 ? 2 : 1);
  if (count > 0) factor_ += 2 * beside * static_cast<double>(every) / static_cast<double>(count);
  factor_ = std::max(1.0, factor_);
}

size_t ErrorCorrelation::bin(size_t i, size_t j) const {
  // One spacing wide, from the nearest on.
  return static_cast<size_t>(std::max(0.0, std::round((place_[i] - place_[j]).norm() / spacing_) - 1));
}

Eigen::MatrixXd ErrorCorrelation::of_gradient(const Eigen::MatrixXd& jacobian) const {
  const Eigen::Index n = jacobian.cols(), points = static_cast<Eigen::Index>(place_.size()),
                     rows = static_cast<Eigen::Index>(rows_);
  CHECK(jacobian.rows() == rows * points * static_cast<Eigen::Index>(axes_));
  Eigen::MatrixXd alone = Eigen::MatrixXd::Zero(n, n), all = alone;
  const Eigen::Index every =
      (points + static_cast<Eigen::Index>(kMostPoints) - 1) / static_cast<Eigen::Index>(kMostPoints);
  for (size_t a = 0; a < axes_; ++a) {
    // Of every point, [rows, P] times the size of its errors.
    std::vector<Eigen::MatrixXd> scaled(place_.size(), Eigen::MatrixXd(rows, n));
    for (Eigen::Index k = 0; k < points; ++k)
      for (Eigen::Index t = 0; t < rows; ++t)
        scaled[k].row(t) = size_[k * axes_ + a] * jacobian.row((t * points + k) * static_cast<Eigen::Index>(axes_) +
                                                               static_cast<Eigen::Index>(a));
    for (Eigen::Index i = 0; i < points; ++i) {
      alone.noalias() += scaled[i].transpose() * scaled[i];
      if (i % every != 0) continue;
      // What others have in common with this point, row by row.
      Eigen::MatrixXd common = Eigen::MatrixXd::Zero(rows, n);
      for (Eigen::Index j = 0; j < points; ++j) {
        const size_t b = i == j || !(spacing_ > 0) ? 0 : bin(static_cast<size_t>(i), static_cast<size_t>(j));
        if (i != j && (!(spacing_ > 0) || b >= with_.size())) continue;
        const std::vector<double>& by_lag = i == j ? own_ : with_[b];
        for (Eigen::Index lag = 0; lag < std::min(rows, static_cast<Eigen::Index>(by_lag.size())); ++lag) {
          // Sums over fewer rows were taken for those of all.
          const double c = by_lag[lag] * static_cast<double>(rows) / static_cast<double>(rows - lag);
          common.bottomRows(rows - lag).noalias() += c * scaled[j].topRows(rows - lag);
          if (lag > 0) common.topRows(rows - lag).noalias() += c * scaled[j].bottomRows(rows - lag);
        }
      }
      all.noalias() += static_cast<double>(every) * scaled[i].transpose() * common;
    }
  }
  all = (0.5 * (all + all.transpose())).eval();
  // Correlations that were estimated need not be those of any errors: no direction gets less than errors of their own
  // give it.
  const SymmetricEigen eigen = symmetric_eigen(alone);
  const Eigen::VectorXd root = eigen.values.cwiseMax(1e-14 * std::max(1e-300, eigen.values.maxCoeff())).cwiseSqrt();
  const Eigen::MatrixXd to = eigen.vectors * root.cwiseInverse().asDiagonal(), from = eigen.vectors * root.asDiagonal();
  const SymmetricEigen ratio = symmetric_eigen(Eigen::MatrixXd(to.transpose() * all * to));
  const Eigen::MatrixXd along = from * ratio.vectors;
  return along * ratio.values.cwiseMax(1.0).asDiagonal() * along.transpose();
}

double unexplained(std::span<const double> errors, std::span<const Vec3f> place, size_t axes) {
  double square = 0, count = 0;
  for (const double r : errors) {
    square += r * r;
    count += r != 0;
  }
  return std::sqrt(ErrorCorrelation(errors, place, axes).factor() * square / std::max(1.0, count));
}

Eigen::MatrixXd covariance_with(const ErrorCorrelation& correlation, const Eigen::MatrixXd& jacobian,
                                const Eigen::MatrixXd& covariance) {
  Eigen::MatrixXd known = covariance;
  for (Eigen::Index i = 0; i < known.rows(); ++i)
    if (std::isinf(known(i, i))) {
      known.row(i).setZero();
      known.col(i).setZero();
    }
  Eigen::MatrixXd out = known + known * (correlation.of_gradient(jacobian) - jacobian.transpose() * jacobian) * known;
  for (Eigen::Index i = 0; i < known.rows(); ++i)
    if (std::isinf(covariance(i, i))) out(i, i) = INFINITY;
  return out;
}

}  // namespace pliant
