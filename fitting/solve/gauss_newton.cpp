#include "fitting/solve/gauss_newton.h"

#include <algorithm>
#include <cmath>

#include "fitting/solve/least_squares.h"
#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kWorn = 1;        // damping, relative to the diagonal of J^T J, at which a corrected J is found anew,
constexpr double kHopeless = 1e6;  // and at which no step will help

/// Parameters at a bound towards which the loss falls.
std::vector<uint8_t> held(const LeastSquares& problem, const VectorXd& p, const VectorXd& gradient) {
  std::vector<uint8_t> out(p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i)
    out[i] = (p[i] <= problem.low[i] && gradient[i] > 0) || (p[i] >= problem.high[i] && gradient[i] < 0);
  return out;
}

/// With damping relative to the diagonal; nothing for parameters that are fixed or that nothing determines, whose
/// `pull` becomes 0.
VectorXd step_of(MatrixXd information, double damping, const std::vector<uint8_t>& fixed, VectorXd& pull) {
  for (Eigen::Index i = 0; i < pull.size(); ++i) {
    information(i, i) += damping * std::max(information(i, i), 1e-300);
    if (!fixed[i] && information(i, i) > 1e-200) continue;
    information.row(i).setZero();
    information.col(i).setZero();
    information(i, i) = 1;
    pull[i] = 0;
  }
  return -solve_symmetric(information, pull);
}

MatrixXd covariance_of(const MatrixXd& information, const std::vector<uint8_t>& fixed) {
  // Directions without information are told apart after scaling every parameter by its own.
  const Eigen::Index n = information.rows();
  VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i)
    scale[i] = information(i, i) > 0 && !fixed[i] ? 1 / std::sqrt(information(i, i)) : 0;
  const MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen(scaled);
  MatrixXd covariance = MatrixXd::Zero(n, n);
  VectorXd lost = VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const VectorXd mode = eigen.vectors.col(k);
    if (eigen.values[k] > 1e-12)
      covariance += mode * mode.transpose() / eigen.values[k];
    else
      lost += mode.cwiseAbs2();
  }
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
  for (Eigen::Index i = 0; i < n; ++i)
    if (scale[i] == 0 || lost[i] > 1e-6) covariance(i, i) = INFINITY;
  return covariance;
}

/// The state before the first iteration.
GaussNewtonState begun(const GaussNewtonOptions& options, LeastSquares& problem, std::span<const double> start) {
  GaussNewtonState state;
  state.parameters = Eigen::Map<const VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
  const VectorXd& p = state.parameters;
  for (Eigen::Index i = 0; i < p.size(); ++i)
    if (!(p[i] >= problem.low[i] && p[i] <= problem.high[i]))
      throw usage_error("least squares", "parameter " + std::to_string(i),
                        "starts at " + std::to_string(p[i]) + ", outside its bounds", "start inside them");
  state.residuals = problem.residuals(p);
  if (state.residuals.size() == 0)
    throw numerical_error("least squares", "the start has no finite residuals", "start from other parameters");
  state.fixed.assign(start.size(), 0);
  state.damping = options.damping;
  state.loss.push_back(problem.loss(p, state.residuals));
  return state;
}

/// J^T J and the prior: of the last J, or of the rough one before the first.
MatrixXd information_of(const GaussNewtonOptions& options, const LeastSquares& problem, const MatrixXd& jacobian) {
  const MatrixXd& J = jacobian.size() ? jacobian : options.rough_jacobian;
  const Eigen::Index count = problem.precision.size();
  MatrixXd information = MatrixXd::Zero(count, count);
  if (J.size()) information = J.transpose() * J;
  information.diagonal() += problem.precision;
  return information;
}

GaussNewtonResult result_of(const GaussNewtonOptions& options, const LeastSquares& problem,
                            const GaussNewtonState& state) {
  GaussNewtonResult result;
  const VectorXd &p = state.parameters, &r = state.residuals;
  result.parameters.assign(p.begin(), p.end());
  result.residuals.assign(r.begin(), r.end());
  result.jacobian = state.differences;
  result.covariance = covariance_of(information_of(options, problem, state.differences), state.fixed);
  const Eigen::Index measured = (r.array() != 0).count();
  const double rms = measured ? std::sqrt(r.squaredNorm() / static_cast<double>(measured)) : 0;
  result.summary = {state.loss, state.evaluations, state.converged, state.stopped_by, rms};
  return result;
}

}  // namespace

GaussNewtonResult gauss_newton(const GaussNewtonOptions& options, const Residuals& residuals,
                               std::span<const double> start, GaussNewtonState state, const GaussNewtonSink& sink) {
  const Eigen::Index count = static_cast<Eigen::Index>(start.size());
  LeastSquares problem(options, residuals, count);
  problem.evaluations = state.evaluations;
  if (!state.stopped_by.empty()) return result_of(options, problem, state);
  if (state.parameters.size() == 0) state = begun(options, problem, start);
  VectorXd &p = state.parameters, &r = state.residuals;
  for (const MatrixXd* given : {&options.jacobian, &options.rough_jacobian})
    CHECK_MSG(given->size() == 0 || (given->rows() == r.size() && given->cols() == count),
              "the given Jacobian is [residuals, parameters]");
  double loss = state.loss.back();
  MatrixXd information = information_of(options, problem, state.jacobian);
  VectorXd gradient;
  const auto keep = [&] {
    state.evaluations = problem.evaluations;
    if (sink) sink(state);
  };
  const auto stop = [&](const char* reason, bool converged) {
    state.stopped_by = reason;
    state.converged = converged;
  };
  // With the J of the state.
  const auto linearise = [&] {
    gradient = state.jacobian.transpose() * r + problem.precision.cwiseProduct(p - problem.prior);
    information = information_of(options, problem, state.jacobian);
    state.fixed = held(problem, p, gradient);
    state.linearised = true;
  };
  if (state.linearised) linearise();

  while (state.stopped_by.empty()) {
    if (state.iteration == options.max_iterations) {
      stop("iterations", false);
      break;
    }
    if (!state.linearised && options.most_jacobians > 0 && state.jacobians == options.most_jacobians) {
      // What is known of the curvature stays that of the last step's start.
      stop("Jacobian limit", false);
      break;
    }
    if (!state.linearised) {
      information = information_of(options, problem, state.jacobian);
      if (options.jacobian.size())
        state.jacobian = options.jacobian;
      else
        state.jacobian = options.principal_axes ? problem.jacobian_along(covariance_of(information, state.fixed), p, r)
                                                : problem.jacobian(p, r);
      state.differences = state.jacobian;
      state.fresh = true;
      ++state.jacobians;
      linearise();
      keep();
    }
    ++state.iteration;
    VectorXd pull = gradient;
    const VectorXd undamped = step_of(information, 0, state.fixed, pull);
    const double left = -0.5 * pull.dot(undamped);  // to fall, if all was linear
    if (pull.cwiseAbs().maxCoeff() == 0) {
      stop("small gradient", true);
      break;
    }
    VectorXd step = step_of(information, state.damping, state.fixed, pull);
    // The direction is kept where one parameter alone would go too far; what such a step gains says nothing of the end.
    const double share = std::min(1.0, (problem.largest_step.array() / step.array().abs().max(1e-300)).minCoeff());
    step *= share;
    const VectorXd trial = (p + step).cwiseMax(problem.low).cwiseMin(problem.high);
    const VectorXd r_trial = trial.allFinite() ? problem.residuals(trial) : VectorXd();
    const double loss_trial = r_trial.size() == r.size() ? problem.loss(trial, r_trial) : INFINITY;
    const VectorXd moved = trial - p;
    const double predicted = -(pull.dot(moved) + 0.5 * moved.dot(information * moved));
    const double fall = loss - loss_trial;
    const bool better = fall > 0;
    if (options.keep_jacobian && std::isfinite(loss_trial)) {
      // The least change, in the scale in which each parameter is seen, that agrees with this trial.
      const VectorXd along = information.diagonal().cwiseProduct(moved);
      if (along.dot(moved) > 0)
        state.jacobian += (r_trial - r - state.jacobian * moved) * along.transpose() / along.dot(moved);
    }
    if (better) {
      p = trial;
      r = r_trial;
      loss = loss_trial;
      state.linearised = state.fresh = false;
      state.loss.push_back(loss);
    }
    // As Nielsen (1999): less the better the step was foreseen, and more for every trial in a row that failed.
    const double foreseen = predicted > 0 ? std::min(1.0, fall / predicted) : 0;
    state.damping *= better ? std::max(0.1, 1 - std::pow(2 * foreseen - 1, 3)) : state.raise;
    state.damping = std::max(1e-12, state.damping);
    state.raise = better ? 2 : 2 * state.raise;
    const bool renewable = !state.fresh && options.jacobian.size() == 0 &&
                           (options.most_jacobians == 0 || state.jacobians < options.most_jacobians);
    if (share == 1 && std::max(better ? fall : std::abs(predicted), left) <= options.tolerance * loss)
      stop("small change", true);
    else if (options.keep_jacobian && renewable && state.damping > kWorn) {
      state.damping = options.damping;
      state.raise = 2;
      state.linearised = false;
    } else if (state.damping > kHopeless)
      stop("no better step", false);
    else if (options.keep_jacobian)
      linearise();
    if (state.stopped_by.empty()) keep();
  }
  keep();
  return result_of(options, problem, state);
}

}  // namespace pliant
