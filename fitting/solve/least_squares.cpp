#include "fitting/solve/least_squares.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd vector_of(const std::vector<double>& given, Eigen::Index count, double otherwise) {
  CHECK_MSG(given.empty() || static_cast<Eigen::Index>(given.size()) == count, "options have one entry per parameter");
  return given.empty() ? VectorXd::Constant(count, otherwise)
                       : VectorXd(Eigen::Map<const VectorXd>(given.data(), count));
}

}  // namespace

LeastSquares::LeastSquares(const GaussNewtonOptions& options, const Residuals& residuals, Eigen::Index count)
    : low(vector_of(options.low, count, -INFINITY)),
      high(vector_of(options.high, count, INFINITY)),
      prior(vector_of(options.prior, count, 0)),
      precision(vector_of(options.prior_sigma, count, INFINITY).array().square().inverse()),
      largest_step(vector_of(options.largest_step, count, INFINITY)),
      residuals_(residuals),
      difference_(vector_of(options.difference, count, 0)),
      parallel_(options.parallel) {}

VectorXd LeastSquares::residuals(const VectorXd& p) {
  ++evaluations;
  try {
    const std::vector<double> r = residuals_({p.data(), static_cast<size_t>(p.size())});
    const VectorXd out = Eigen::Map<const VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
    return out.allFinite() ? out : VectorXd();
  } catch (const Error& error) {
    if (error.failure != Failure::kNumerical) throw;
    return {};
  }
}

double LeastSquares::loss(const VectorXd& p, const VectorXd& r) const {
  return 0.5 * r.squaredNorm() + 0.5 * ((p - prior).array().square() * precision.array()).sum();
}

MatrixXd LeastSquares::jacobian(const VectorXd& p, const VectorXd& r) {
  MatrixXd jacobian = MatrixXd::Zero(r.size(), p.size());
  const auto column = [&](std::ptrdiff_t i) {
    const double step = difference_[i] > 0 ? difference_[i] : 1e-4 * std::max(1.0, std::abs(p[i]));
    // A difference that would leave the bounds, or a point that cannot be, is replaced by the other side's.
    const auto moved = [&](double by, double& at) {
      VectorXd q = p;
      at = q[i] = std::clamp(p[i] + by, low[i], high[i]);
      const VectorXd out = at == p[i] ? VectorXd() : residuals(q);
      if (out.size() != r.size()) at = p[i];
      return out.size() == r.size() ? out : r;
    };
    double above = p[i], below = p[i];
    VectorXd upper = moved(step, above), lower = r;
    if (above == p[i]) lower = moved(-step, below);
    if (above != below) jacobian.col(i) = (upper - lower) / (above - below);
  };
  if (parallel_)
    parallel_for(p.size(), column);
  else
    for (Eigen::Index i = 0; i < p.size(); ++i) column(i);
  return jacobian;
}

MatrixXd LeastSquares::jacobian_along(const MatrixXd& covariance, const VectorXd& p, const VectorXd& r) {
  VectorXd width(p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const double variance = covariance(i, i);
    const double otherwise = difference_[i] > 0 ? difference_[i] : 1e-4 * std::max(1.0, std::abs(p[i]));
    width[i] = std::isfinite(variance) && variance > 0 ? std::sqrt(variance) : otherwise;
  }
  MatrixXd correlation = MatrixXd::Identity(p.size(), p.size());
  for (Eigen::Index a = 0; a < p.size(); ++a)
    for (Eigen::Index b = 0; b < a; ++b) {
      const double c = covariance(a, b) / (width[a] * width[b]);
      if (std::isfinite(covariance(a, a)) && std::isfinite(covariance(b, b)) && std::isfinite(c))
        correlation(a, b) = correlation(b, a) = c;
    }
  const SymmetricEigen eigen = symmetric_eigen(correlation);
  MatrixXd change = MatrixXd::Zero(r.size(), p.size());  // of r along each axis
  VectorXd length(p.size());
  const auto along = [&](std::ptrdiff_t k) {
    VectorXd axis = width.cwiseProduct(eigen.vectors.col(k));
    length[k] = std::sqrt(std::max(1e-12, eigen.values[k]));
    length[k] = std::min(length[k], (largest_step.array() / axis.array().abs().max(1e-300)).minCoeff());
    axis *= length[k];
    const auto at = [&](double side) {
      const VectorXd q = p + side * axis;
      if ((q.array() < low.array()).any() || (q.array() > high.array()).any()) return VectorXd();
      return residuals(q);
    };
    const VectorXd upper = at(1), lower = at(-1);
    const bool above = upper.size() == r.size(), below = lower.size() == r.size();
    if (above || below) change.col(k) = ((above ? upper : r) - (below ? lower : r)) / (above && below ? 2.0 : 1.0);
  };
  if (parallel_)
    parallel_for(p.size(), along);
  else
    for (Eigen::Index k = 0; k < p.size(); ++k) along(k);
  // r changes by J (width o eigenvector) length along an axis; the eigenvectors are orthonormal.
  return change * length.cwiseInverse().asDiagonal() * eigen.vectors.transpose() * width.cwiseInverse().asDiagonal();
}

}  // namespace pliant
