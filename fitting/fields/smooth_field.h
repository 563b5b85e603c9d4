#pragma once

#include <Eigen/Core>
#include <cmath>

#include "fitting/fields/field.h"
#include "gaussians/base/types.h"

namespace pliant {

struct SmoothFieldOptions {
  double sigma = 1.15;  ///< standard deviation that is expected anywhere, in the field's unit (half a decade of ln E)
  double level_sigma =
      0;                ///< of a constant that is added everywhere, as the level about which values vary is not known
  double length = 0;    ///< over which values are alike, in the points' unit; 0 = a fifth of the box's diagonal
  int modes = 32;       ///< at most
  double least = 1e-3;  ///< share of the sum of all variances, without the level's, below which a mode is left out
  int centres = 200;    ///< at most, of the points that the modes are found on
};

/// Gaussian random field of covariance level_sigma^2 + sigma^2 exp(-|x - y|^2 / (2 length^2)), by its strongest
/// principal modes (Karhunen-Loeve, on spread centres after Nystroem): one channel, zero mean, linear in its
/// parameters, each of which has a standard normal prior.
class SmoothField : public Field {
 public:
  SmoothField(const SmoothFieldOptions& options, std::span<const Vec3f> points);

  size_t points() const override { return static_cast<size_t>(modes_.rows()); }
  int channels() const override { return 1; }
  size_t parameters() const { return static_cast<size_t>(modes_.cols()); }
  std::vector<double> constant(std::span<const double> value) const override;
  std::vector<double> values(std::span<const double> parameters) const override;
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override;
  /// [points, parameters] values = modes * parameters.
  const Eigen::MatrixXd& modes() const { return modes_; }
  /// Standard deviation at a point, and what of its square the modes leave out.
  double prior_sigma() const { return std::hypot(sigma_, level_sigma_); }
  double variance_left_out(size_t point) const;
  /// [M, parameters] the modes at other points, and their derivatives along an axis of space.
  Eigen::MatrixXd modes_at(std::span<const Vec3f> points) const;
  Eigen::MatrixXd slopes(std::span<const Vec3f> points, int axis) const;

 private:
  double varying(const Vec3f& a, const Vec3f& b) const;
  double covariance(const Vec3f& a, const Vec3f& b) const { return level_sigma_ * level_sigma_ + varying(a, b); }

  double sigma_ = 1, level_sigma_ = 0, length_ = 1;
  std::vector<Vec3f> centres_;
  Eigen::MatrixXd weights_;  // [centres, parameters]
  Eigen::MatrixXd modes_;
};

}  // namespace pliant
