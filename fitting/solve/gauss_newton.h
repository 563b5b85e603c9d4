#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace pliant {

/// What a least-squares fit compares: r(parameters) [R], each divided by its standard deviation; an entry without a
/// measurement is 0.  An Error{kNumerical}, or an entry that is not finite, marks parameters that cannot be.
using Residuals = std::function<std::vector<double>(std::span<const double> parameters)>;

/// Vectors are [P], or empty for the default of each parameter.
struct GaussNewtonOptions {
  std::vector<double> difference;          ///< steps of the differences for J; default 1e-4 max(1, |p|)
  std::vector<double> low, high;           ///< bounds that hold at every trial; default none
  std::vector<double> largest_step;        ///< change in one iteration; default none
  std::vector<double> prior, prior_sigma;  ///< ((p - prior) / sigma)^2 / 2 joins the loss; sigma infinite = none
  Eigen::MatrixXd jacobian;    ///< [R, P] of a similar problem, instead of differences: the chord method; empty = none
  bool keep_jacobian = false;  ///< after every trial, accepted or not, J is corrected by what it showed (Broyden 1965),
                               ///< and found anew only when steps have to be cut short
  bool parallel = false;       ///< columns of J at the same time: `residuals` is called from several threads
  /// J by central differences along the principal axes of the covariance that the last J and the prior give, one
  /// standard deviation to either side.  What measurements hardly see are combinations of parameters of which each
  /// alone is seen well: differences along each alone drown them in rounding errors, and one-sided ones see slopes
  /// where there is only curvature.
  bool principal_axes = false;
  Eigen::MatrixXd rough_jacobian;  ///< [R, P] for the first of these; empty = the prior alone
  int max_iterations = 20;         ///< accepted or not
  int most_jacobians = 0;          ///< found by differences; 0 = no limit
  double damping = 1e-3;           ///< of Levenberg and Marquardt at the start, relative to the diagonal of J^T J
  double tolerance =
      1e-8;  ///< of the loss: converged when a step lowers it by no more, nor would a whole one by what J says
};

struct GaussNewtonSummary {
  std::vector<double> loss;  ///< at the start and after every accepted step: half the sum of squares, with the prior
  int evaluations = 0;
  bool converged = false;
  std::string stopped_by;  ///< "small change", "small gradient", "no better step", "iterations" or "Jacobian limit"
  double rms = 0;          ///< of the residuals that are not exactly 0
};

struct GaussNewtonResult {
  std::vector<double> parameters;  ///< [P]
  std::vector<double> residuals;   ///< [R] there
  Eigen::MatrixXd jacobian;        ///< [R, P] as given, or found last by differences; empty without a step
  Eigen::MatrixXd covariance;      ///< [P, P] inverse of its J^T J + prior for residuals of unit variance; what nothing
                                   ///< determines, and a parameter at its bound, has an infinite diagonal
  GaussNewtonSummary summary;

  double sigma(int parameter) const { return std::sqrt(covariance(parameter, parameter)); }
};

/// Everything that an iteration starts from: a fit continues from here bit for bit, and one that is finished gives its
/// result without another evaluation.
struct GaussNewtonState {
  Eigen::VectorXd parameters, residuals;   ///< [P], [R] there; empty = not begun
  Eigen::MatrixXd jacobian, differences;   ///< [R, P] corrected by later steps, and as in the result
  std::vector<uint8_t> fixed;              ///< [P] 1 = at a bound, when J was last used
  double damping = 0, raise = 2;           ///< and by what it grows with the next trial that fails
  bool linearised = false, fresh = false;  ///< J belongs to the parameters; and was found by differences there
  int iteration = 0, jacobians = 0;        ///< begun, and found by differences or taken as given
  int evaluations = 0;
  std::vector<double> loss;  ///< as in the summary
  bool converged = false;
  std::string stopped_by;  ///< empty = not finished
};

/// Called whenever J was found, and after every step, accepted or not.  What it throws ends the fit.
using GaussNewtonSink = std::function<void(const GaussNewtonState&)>;

/// Least squares by Gauss-Newton steps with the damping of Levenberg (1944) and Marquardt (1963); a parameter at a
/// bound stays there while the loss pulls it outwards.  J by differences of `residuals`.  Goes on from `state` where
/// that has begun, with the options it began with.  Throws Error{kNumerical} when the start itself has no finite
/// residuals, Error{kUsage} for bounds that exclude it.
GaussNewtonResult gauss_newton(const GaussNewtonOptions& options, const Residuals& residuals,
                               std::span<const double> start, GaussNewtonState state = {},
                               const GaussNewtonSink& sink = {});

}  // namespace pliant
