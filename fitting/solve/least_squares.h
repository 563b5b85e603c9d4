#pragma once

#include <Eigen/Core>
#include <atomic>

#include "fitting/solve/gauss_newton.h"

namespace pliant {

/// A least-squares problem of P parameters with its bounds and its prior, its derivatives by differences, and how often
/// it was evaluated.  `residuals` must outlive it.
class LeastSquares {
 public:
  /// CHECKs that options with entries have one for each of `count` parameters.
  LeastSquares(const GaussNewtonOptions& options, const Residuals& residuals, Eigen::Index count);

  /// [R] at p [P]; empty where the parameters cannot be.
  Eigen::VectorXd residuals(const Eigen::VectorXd& p);
  /// Half the sum of squares of r, with the prior.
  double loss(const Eigen::VectorXd& p, const Eigen::VectorXd& r) const;
  /// [R, P] by a difference along each parameter; r are the residuals at p.
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& p, const Eigen::VectorXd& r);
  /// By central differences along the principal axes of a covariance, in the scale of each parameter's own width.
  Eigen::MatrixXd jacobian_along(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& p, const Eigen::VectorXd& r);

  Eigen::VectorXd low, high, prior, precision, largest_step;  ///< [P] the options, or their defaults
  std::atomic<int> evaluations = 0;

 private:
  const Residuals& residuals_;
  Eigen::VectorXd difference_;
  bool parallel_;
};

}  // namespace pliant
