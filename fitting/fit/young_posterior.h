#pragma once

#include <Eigen/Core>
#include <functional>

#include "fitting/fields/field.h"
#include "fitting/objective/motion.h"
#include "fitting/objective/track_loss.h"
#include "fitting/solve/gauss_newton.h"

namespace pliant {

/// What measurements and a prior leave open.
struct YoungPosterior {
  std::vector<double> young_sigma;  ///< [N] decades, one standard deviation of log10 E of each particle
  double log10_sigma = 0;           ///< of the mean of log10 E
  double log_damping_sigma = 0;     ///< of ln of the damping time; 0 where the motion has none
};

/// How far `posterior_about` is: it goes on from here, and ends as if it had not been interrupted.
using PosteriorState = std::vector<GaussNewtonState>;
/// Called when derivatives along all directions are found.  What it throws ends it.
using PosteriorSink = std::function<void(const PosteriorState&)>;

/// [N, P] derivatives of a one-channel field's values by its parameters.
Eigen::MatrixXd sensitivity(const Field& field, std::span<const double> parameters);

/// `covariance` [P, P] of least squares (gauss_newton.h) where what it leaves infinite, as that of a parameter at its
/// bound, is the variance that was expected before: `prior_sigma` [P] squared, and independent of the others.
Eigen::MatrixXd with_prior_where_infinite(Eigen::MatrixXd covariance, std::span<const double> prior_sigma);

/// From derivatives of ln E [N, P] and the covariance [P, P] of the parameters; without damping.  A deviation is
/// infinite where E depends on a parameter of infinite variance.
YoungPosterior young_posterior(const Eigen::MatrixXd& ln_young_by, const Eigen::MatrixXd& covariance);

/// The Gaussian posterior (J^T J / sigma^2 + prior)^-1 of ln E, in the directions of a field whose parameters are
/// expected within `field_sigma` of 0, of damping and of a smooth start, about a motion that explains `tracks` (on its
/// roll-out).  J by differences of two roll-outs along each direction, and again along the principal axes of what these
/// say; sigma is what the motion leaves unexplained (correlation.h), but for what stays of a point's errors
/// (staying_errors.h).  `stop` is asked before every roll-out; true ends it with Error{kInterrupted}.
YoungPosterior posterior_about(const Motion<float>& motion, const Field& field, double field_sigma,
                               const TrackLoss<float>& tracks, const std::function<bool()>& stop = {},
                               PosteriorState state = {}, const PosteriorSink& sink = {});

}  // namespace pliant
