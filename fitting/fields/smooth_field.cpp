#include "fitting/fields/smooth_field.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"

namespace pliant {
namespace {

/// Points that are far from each other: each the farthest from those before it.
std::vector<Vec3f> spread(std::span<const Vec3f> points, int count) {
  std::vector<Vec3f> centres;
  std::vector<float> distance(points.size(), INFINITY);
  size_t next = 0;
  while (static_cast<int>(centres.size()) < count && distance[next] > 0) {
    const Vec3f centre = points[next];
    centres.push_back(centre);
    for (size_t i = 0; i < points.size(); ++i) distance[i] = std::min(distance[i], (points[i] - centre).squaredNorm());
    next = std::max_element(distance.begin(), distance.end()) - distance.begin();
  }
  return centres;
}

}  // namespace

SmoothField::SmoothField(const SmoothFieldOptions& options, std::span<const Vec3f> points) {
  CHECK(!points.empty());
  if (!(options.sigma > 0) || !(options.level_sigma >= 0) || options.modes < 1 || options.centres < 1 ||
      !(options.length >= 0))
    throw usage_error("smooth field", "sigma, modes, centres, length", "must be positive", "correct them");
  Box box;
  for (const Vec3f& x : points) box.add(x);
  sigma_ = options.sigma;
  level_sigma_ = options.level_sigma;
  length_ = options.length > 0 ? options.length : std::max(1e-12, 0.2 * double(box.size().norm()));
  centres_ = spread(points, options.centres);
  const Eigen::Index n = static_cast<Eigen::Index>(centres_.size());
  Eigen::MatrixXd K(n, n);
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b) K(a, b) = covariance(centres_[a], centres_[b]);
  const SymmetricEigen eigen = symmetric_eigen(K);
  Eigen::Index kept = 0;
  const double least = options.least * static_cast<double>(n) * sigma_ * sigma_;
  while (kept < std::min<Eigen::Index>(n, options.modes) && eigen.values[n - 1 - kept] > least) ++kept;
  // Mode k at x: covariance with the centres times u_k / sqrt(lambda_k).
  weights_.resize(n, kept);
  for (Eigen::Index k = 0; k < kept; ++k)
    weights_.col(k) = eigen.vectors.col(n - 1 - k) / std::sqrt(eigen.values[n - 1 - k]);
  modes_ = modes_at(points);
}

double SmoothField::varying(const Vec3f& a, const Vec3f& b) const {
  return sigma_ * sigma_ * std::exp(-0.5 * double((a - b).squaredNorm()) / (length_ * length_));
}

Eigen::MatrixXd SmoothField::modes_at(std::span<const Vec3f> points) const {
  Eigen::MatrixXd by(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(centres_.size()));
  for (Eigen::Index i = 0; i < by.rows(); ++i)
    for (Eigen::Index a = 0; a < by.cols(); ++a) by(i, a) = covariance(points[i], centres_[a]);
  return by * weights_;
}

Eigen::MatrixXd SmoothField::slopes(std::span<const Vec3f> points, int axis) const {
  Eigen::MatrixXd by(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(centres_.size()));
  for (Eigen::Index i = 0; i < by.rows(); ++i)
    for (Eigen::Index a = 0; a < by.cols(); ++a)
      by(i, a) = -double(points[i][axis] - centres_[a][axis]) / (length_ * length_) * varying(points[i], centres_[a]);
  return by * weights_;
}

double SmoothField::variance_left_out(size_t point) const {
  return std::max(0.0, prior_sigma() * prior_sigma() - modes_.row(static_cast<Eigen::Index>(point)).squaredNorm());
}

std::vector<double> SmoothField::constant(std::span<const double> value) const {
  CHECK(value.size() == 1);
  const Eigen::VectorXd p = modes_.colPivHouseholderQr().solve(Eigen::VectorXd::Constant(modes_.rows(), value[0]));
  return {p.begin(), p.end()};
}

std::vector<double> SmoothField::values(std::span<const double> parameters) const {
  CHECK(parameters.size() == this->parameters());
  const Eigen::VectorXd v = modes_ * Eigen::Map<const Eigen::VectorXd>(parameters.data(), modes_.cols());
  return {v.begin(), v.end()};
}

std::vector<double> SmoothField::values_adjoint(std::span<const double> parameters,
                                                std::span<const double> adj_values) const {
  CHECK(parameters.size() == this->parameters() && adj_values.size() == points());
  const Eigen::VectorXd adj = modes_.transpose() * Eigen::Map<const Eigen::VectorXd>(adj_values.data(), modes_.rows());
  return {adj.begin(), adj.end()};
}

}  // namespace pliant
