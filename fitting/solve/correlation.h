#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// How errors [rows, points, axes] of neighbouring points in neighbouring rows go together: their mean correlation by
/// the distance of the points and the rows between them, no farther than where that in space alone, and that in time
/// alone, first come to zero.  Axes are independent; each point has errors of its own size.
class ErrorCorrelation {
 public:
  /// `place` [points], of any rows.
  ErrorCorrelation(std::span<const double> errors, std::span<const Vec3f> place, size_t axes);

  /// Sum of an error's correlations with all others: what widens the variance of a mean.  At least 1.
  double factor() const { return factor_; }

  /// Covariance of J^T e for J [rows points axes, P], where e are errors of these sizes and correlations; in no
  /// direction less than for independent ones.
  Eigen::MatrixXd of_gradient(const Eigen::MatrixXd& jacobian) const;

 private:
  size_t bin(size_t i, size_t j) const;

  std::vector<Vec3f> place_;
  size_t axes_ = 1, rows_ = 0;
  double spacing_ = 0;                     // of the points; 0 = each is alone
  std::vector<double> size_;               // [points, axes] root mean square of the errors that are not 0
  std::vector<double> own_;                // [lag] of a point with itself; the first is 1
  std::vector<std::vector<double>> with_;  // [bin of distance][lag], where a lag stands for both directions
  double factor_ = 1;
};

/// Standard deviation that errors [rows, points, axes] would need to weigh as much as they do if all were independent:
/// the root mean square of those that are not 0, wider by the root of that factor.
double unexplained(std::span<const double> errors, std::span<const Vec3f> place, size_t axes);

/// Covariance of a least-squares fit whose errors are not independent (the sandwich of Huber 1967 with correlations as
/// in Newey and West 1987): `covariance` [P, P] is the inverse of J^T J and the priors, J and `errors` those of the fit
/// at its end. Infinite diagonals stay.
Eigen::MatrixXd covariance_with(const ErrorCorrelation& correlation, const Eigen::MatrixXd& jacobian,
                                const Eigen::MatrixXd& covariance);

}  // namespace pliant
