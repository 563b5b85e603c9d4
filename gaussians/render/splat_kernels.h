#pragma once

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/pack.h"

namespace pliant {

/// Constants of the reference 3DGS rasteriser; forward and reverse passes use the same ones.
namespace splat {
constexpr double kNear = 0.2;            ///< Gaussians nearer than this are not drawn (scene units)
constexpr double kFrustumClamp = 1.3;    ///< the Jacobian is taken inside the frustum widened by this factor
constexpr double kScreenVariance = 0.3;  ///< low-pass filter added to the 2D covariance (px^2)
constexpr double kMaxAlpha = 0.99;
constexpr double kMinAlpha = 1.0 / 255;      ///< smaller contributions are skipped
constexpr double kMinTransmittance = 1e-4;   ///< blending ends before the transmittance falls below this
constexpr double kMinCompensation = 2.5e-5;  ///< smallest ratio of determinants in antialiased rendering
}  // namespace splat

/// A camera as the kernels use it.
template <class T>
struct View {
  Mat3<T> R;                       ///< cam_from_world
  Vec3<T> t, centre;               ///< translation of cam_from_world, camera centre in the world
  T fx, fy, cx, cy;                ///< pixels
  T low_x, high_x, low_y, high_y;  ///< bounds of x/z and y/z at which the Jacobian is taken
  int width, height;
};

template <class T>
View<T> make_view(const Camera& camera) {
  View<T> view;
  view.R = camera.cam_from_world.linear().cast<T>();
  view.t = camera.cam_from_world.translation().cast<T>();
  view.centre = camera.centre().cast<T>();
  view.fx = T(camera.fx), view.fy = T(camera.fy), view.cx = T(camera.cx), view.cy = T(camera.cy);
  // With the principal point in the middle these are -+ 1.3 tan(field of view / 2).
  const double extra_x = (splat::kFrustumClamp - 1) * 0.5 * camera.width, low_x = camera.cx + extra_x;
  const double extra_y = (splat::kFrustumClamp - 1) * 0.5 * camera.height, low_y = camera.cy + extra_y;
  view.low_x = T(-low_x / camera.fx), view.high_x = T((camera.width - camera.cx + extra_x) / camera.fx);
  view.low_y = T(-low_y / camera.fy), view.high_y = T((camera.height - camera.cy + extra_y) / camera.fy);
  view.width = camera.width, view.height = camera.height;
  return view;
}

/// Projected Gaussian: mean in pixels (the centre of pixel (i, j) is (i + 0.5, j + 0.5)), depth, 2D covariance.
template <class T>
struct Footprint {
  T u, v, depth;
  T xx, xy, yy, determinant;  ///< covariance including the low-pass filter (px^2), and its determinant
  T compensation;             ///< factor on the opacity that keeps the integral of alpha, for antialiased rendering
};

/// Rotation times scales of a Gaussian, so that covariance = A A^T.  A zero quaternion means no rotation.
template <class T>
HOST_DEVICE Mat3<T> covariance_factor(const Eigen::Matrix<T, 4, 1>& wxyz, const Vec3<T>& log_scale) {
  const Mat3<T> R = wxyz.squaredNorm() == T(0) ? Mat3<T>(Mat3<T>::Identity()) : rotation_matrix<T>(wxyz);
  return R * log_scale.array().exp().matrix().asDiagonal();
}

/// Elliptical weighted average projection (Zwicker et al. 2001, eq. 31): covariance2D = J W A (J W A)^T with the
/// Jacobian J of the pinhole projection at the mean.  False when the Gaussian is not drawn: nearer than kNear, or not
/// finite.  The determinant is summed from non-negative terms (Binet and Cauchy), so that thin splats keep theirs.
template <class T>
HOST_DEVICE bool project(const View<T>& view, const Vec3<T>& position, const Mat3<T>& A, Footprint<T>& out) {
  const Vec3<T> p = view.R * position + view.t;
  if (!(p[2] > T(splat::kNear))) return false;
  const T x = p[0] / p[2], y = p[1] / p[2];
  out.u = view.fx * x + view.cx, out.v = view.fy * y + view.cy, out.depth = p[2];
  const T clamped_x = x < view.low_x ? view.low_x : x > view.high_x ? view.high_x : x;
  const T clamped_y = y < view.low_y ? view.low_y : y > view.high_y ? view.high_y : y;
  const Vec3<T> jx = (view.R.row(0) - clamped_x * view.R.row(2)).transpose() * (view.fx / p[2]);
  const Vec3<T> jy = (view.R.row(1) - clamped_y * view.R.row(2)).transpose() * (view.fy / p[2]);
  const Vec3<T> mx = A.transpose() * jx, my = A.transpose() * jy;
  const T blur = T(splat::kScreenVariance), sharp = mx.cross(my).squaredNorm();
  const T xx = mx.squaredNorm(), yy = my.squaredNorm();
  out.xx = xx + blur, out.yy = yy + blur, out.xy = mx.dot(my);
  out.determinant = sharp + blur * (xx + yy) + blur * blur;
  const T ratio = sharp / out.determinant;
  out.compensation = std::sqrt(ratio > T(splat::kMinCompensation) ? ratio : T(splat::kMinCompensation));
  // One comparison that is false for infinity and for NaN anywhere in the footprint.
  return std::isfinite(out.u + out.v + out.depth + out.determinant / out.yy);
}

/// What a splat adds to one row of pixels: alpha = opacity exp(power - half_inverse_x (x - x0)^2).  The quadratic form
/// is completed to squares, -(1/2) d^T covariance^-1 d = power - half_inverse_x (x - x0)^2, which is never positive.
template <class T>
struct SplatRow {
  T x0, power;
};

template <class T>
HOST_DEVICE SplatRow<T> splat_row(T u, T v, T slope, T half_inverse_y, T y) {
  const T dy = y - v;
  return {u + slope * dy, -half_inverse_y * dy * dy};
}

/// Alpha at pixel centres x; V is T or a pack of T.
template <bool kCutOffs, class V, class T>
HOST_DEVICE V splat_alpha(T opacity, T half_inverse_x, const SplatRow<T>& row, V x) {
  const V e = x - row.x0;
  const V alpha = opacity * exp_nonpositive(row.power - half_inverse_x * e * e);
  if constexpr (!kCutOffs) return alpha;
  const V limit = V{} + T(splat::kMaxAlpha);
  return alpha < limit ? alpha : limit;
}

/// Blend weight of the next splat, alpha * transmittance, and the transmittance after it.  A pixel whose transmittance
/// would fall below the limit takes nothing more; it is marked by the negative of its transmittance.
template <bool kCutOffs, class T, class V>
HOST_DEVICE V blend(V alpha, V& transmittance) {
  const V after = transmittance * (T(1) - alpha);
  const V weight = alpha * transmittance;
  if constexpr (!kCutOffs) {
    transmittance = after;
    return weight;
  }
  const auto counts = alpha >= V{} + T(splat::kMinAlpha);
  const auto takes = counts & (after >= V{} + T(splat::kMinTransmittance));
  const V closed = transmittance < -transmittance ? transmittance : -transmittance;
  const V otherwise = counts ? closed : transmittance;
  transmittance = takes ? after : otherwise;
  return takes ? weight : V{};
}

}  // namespace pliant
