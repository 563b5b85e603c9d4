#include "fitting/fit/young_posterior.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "fitting/fit/fit_gradient.h"
#include "fitting/modal/start_shapes.h"
#include "fitting/solve/correlation.h"
#include "fitting/solve/staying_errors.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

const double kDecade = std::log(10.0);
// Of ln E where a direction acts most, to either side: first small enough for what is seen well, whose slope it is;
// then up to what the time step bears, so that rounding errors are not taken for what is hardly seen.
constexpr double kFarthest[] = {0.25, 0.8};
constexpr int kStartModes = 4;       // of the start's velocity along each axis,
constexpr double kStartSigma = 0.3;  // whose amplitudes are expected to be right but for this share of its speed
constexpr double kDampingSigma = 2, kDampingStep = 0.3;  // of ln of the damping time: expected, and to either side

/// Smooth changes of the start's velocity, their unit its typical speed; none of a body at rest.
std::optional<StartShapes> start_shapes(const Motion<float>& motion) {
  double square = 0;
  for (const Vec3f& v : motion.start.v) square += v.squaredNorm() / static_cast<double>(motion.start.size());
  if (!(square > 0)) return std::nullopt;
  return StartShapes::smooth(motion.particles, kStartModes, std::sqrt(square) / motion.particles.cell_size);
}

}  // namespace

Eigen::MatrixXd sensitivity(const Field& field, std::span<const double> parameters) {
  std::vector<double> moved(parameters.begin(), parameters.end());
  const std::vector<double> here = field.values(moved);
  Eigen::MatrixXd by(static_cast<Eigen::Index>(here.size()), static_cast<Eigen::Index>(moved.size()));
  for (size_t a = 0; a < moved.size(); ++a) {
    const double before = moved[a];
    moved[a] += 1e-4;
    const std::vector<double> there = field.values(moved);
    moved[a] = before;
    for (size_t i = 0; i < here.size(); ++i)
      by(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)) = (there[i] - here[i]) / 1e-4;
  }
  return by;
}

Eigen::MatrixXd with_prior_where_infinite(Eigen::MatrixXd covariance, std::span<const double> prior_sigma) {
  CHECK(covariance.rows() == static_cast<Eigen::Index>(prior_sigma.size()));
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    if (std::isfinite(covariance(i, i))) continue;
    covariance.row(i).setZero();
    covariance.col(i).setZero();
    covariance(i, i) = std::pow(prior_sigma[static_cast<size_t>(i)], 2);
  }
  return covariance;
}

YoungPosterior young_posterior(const Eigen::MatrixXd& ln_young_by, const Eigen::MatrixXd& covariance) {
  // 0 times an infinite variance is 0 here: such parameters are taken out, and count where E depends on them.
  const std::vector<double> none(static_cast<size_t>(covariance.rows()), 0.0);
  const Eigen::MatrixXd known = with_prior_where_infinite(covariance, none);
  const auto sigma = [&](const Eigen::RowVectorXd& by, double square) {
    for (Eigen::Index i = 0; i < by.size(); ++i)
      if (!std::isfinite(covariance(i, i)) && by[i] != 0) return static_cast<double>(INFINITY);
    return std::sqrt(std::max(0.0, square)) / kDecade;
  };
  YoungPosterior out;
  const Eigen::RowVectorXd mean = ln_young_by.colwise().mean();
  out.log10_sigma = sigma(mean, mean.dot(mean * known));
  const Eigen::VectorXd square = (ln_young_by * known).cwiseProduct(ln_young_by).rowwise().sum();
  for (Eigen::Index i = 0; i < square.size(); ++i) out.young_sigma.push_back(sigma(ln_young_by.row(i), square[i]));
  return out;
}

YoungPosterior posterior_about(const Motion<float>& motion, const Field& field, double field_sigma,
                               const TrackLoss<float>& tracks, const std::function<bool()>& stop, PosteriorState state,
                               const PosteriorSink& sink) {
  const bool damping = motion.options.simulate.damping_time > 0;
  GradientFitParameters at;
  at.material = field.constant(std::vector<double>{0.0});
  const Eigen::MatrixXd by = sensitivity(field, at.material);
  const std::optional<StartShapes> shapes = start_shapes(motion);
  const size_t directions = at.material.size(), amplitudes = shapes ? shapes->size() : 0,
               count = directions + damping + amplitudes;
  double noise = 1, staying = 0;
  const size_t columns = tracks.tracks().rest.size() * static_cast<size_t>(tracks.tracks().axes());
  const auto residuals = [&](std::span<const double> p) {
    if (stop && stop())
      throw Error(Failure::kInterrupted, "fit", "", "interrupted", "run the same command to continue");
    GradientFitParameters there = at;
    there.material.assign(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(directions));
    if (damping) there.damping = p[directions];
    Motion<float> moved = with_fields(motion, {&field, nullptr, damping, nullptr}, there);
    if (shapes) {
      const SimulationState change = shapes->state(motion.particles, {}, p.last(amplitudes));
      for (size_t i = 0; i < change.size(); ++i) {
        moved.start.v[i] += change.v[i];
        moved.start.C[i] += change.C[i];
      }
    }
    std::vector<double> errors;
    int frame = 0;
    simulate<float>(moved.options.simulate, moved.particles, moved.interactions, moved.start,
                    [&](const SimulationState& state) {
                      tracks.append_errors(frame++, state, noise, errors);
                      return true;
                    });
    even_out(errors, errors, columns, 0, staying);
    return errors;
  };
  const std::vector<double> here(count, 0.0);
  staying = staying_share(residuals(here), columns);
  const std::vector<double> left = residuals(here);
  noise = std::max(1e-12, unexplained(left, tracks.tracks().rest, tracks.tracks().axes()));

  GaussNewtonOptions options;
  options.max_iterations = 1;  // which finds J
  options.principal_axes = options.parallel = true;
  options.prior.assign(count, 0.0);
  options.prior_sigma.assign(count, field_sigma);
  options.largest_step.assign(count, kStartSigma);
  std::fill_n(options.prior_sigma.end() - static_cast<std::ptrdiff_t>(amplitudes), amplitudes, kStartSigma);
  if (damping) {
    options.prior_sigma[directions] = kDampingSigma;
    options.largest_step[directions] = kDampingStep;
  }
  GaussNewtonResult found;
  state.resize(std::size(kFarthest));
  for (size_t k = 0; k < state.size(); ++k) {
    const double farthest = kFarthest[k];
    for (size_t a = 0; a < directions; ++a)
      options.largest_step[a] = farthest / std::max(1e-12, by.col(static_cast<Eigen::Index>(a)).cwiseAbs().maxCoeff());
    options.difference = options.largest_step;
    options.rough_jacobian = found.jacobian;
    found = gauss_newton(options, residuals, here, state[k], [&](const GaussNewtonState& now) {
      state[k] = now;
      if (sink) sink(state);
    });
  }
  const ErrorCorrelation correlation(found.residuals, tracks.tracks().rest, tracks.tracks().axes());
  found.covariance =
      with_prior_where_infinite(covariance_with(correlation, found.jacobian, found.covariance), options.prior_sigma);
  const Eigen::Index size = static_cast<Eigen::Index>(directions);
  YoungPosterior out = young_posterior(by, found.covariance.topLeftCorner(size, size));
  if (damping) out.log_damping_sigma = found.sigma(static_cast<int>(directions));
  return out;
}

}  // namespace pliant
