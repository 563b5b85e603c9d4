#pragma once

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/splat.h"

namespace pliant {

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

/// Derivatives of A = covariance_factor(wxyz, log_scale), written: through R(q / |q|) and through the scales.
template <class T>
HOST_DEVICE void covariance_factor_adjoint(const Eigen::Matrix<T, 4, 1>& wxyz, const Vec3<T>& log_scale,
                                           const Mat3<T>& A, const Mat3<T>& adj_A, Eigen::Matrix<T, 4, 1>& adj_wxyz,
                                           Vec3<T>& adj_log_scale) {
  adj_log_scale = A.cwiseProduct(adj_A).colwise().sum().transpose();
  adj_wxyz.setZero();
  const T norm = wxyz.norm();
  if (norm == T(0)) return;
  const Mat3<T> G = adj_A * log_scale.array().exp().matrix().asDiagonal();
  const Eigen::Matrix<T, 4, 1> q = wxyz / norm;
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  Eigen::Matrix<T, 4, 1> adj_q;
  adj_q[0] = x * (G(2, 1) - G(1, 2)) + y * (G(0, 2) - G(2, 0)) + z * (G(1, 0) - G(0, 1));
  adj_q[1] = y * (G(0, 1) + G(1, 0)) + z * (G(0, 2) + G(2, 0)) + w * (G(2, 1) - G(1, 2)) - 2 * x * (G(1, 1) + G(2, 2));
  adj_q[2] = x * (G(0, 1) + G(1, 0)) + z * (G(1, 2) + G(2, 1)) + w * (G(0, 2) - G(2, 0)) - 2 * y * (G(0, 0) + G(2, 2));
  adj_q[3] = x * (G(0, 2) + G(2, 0)) + y * (G(1, 2) + G(2, 1)) + w * (G(1, 0) - G(0, 1)) - 2 * z * (G(0, 0) + G(1, 1));
  // 2 dR/dq is tangent already up to the part along q, which the normalisation takes away.
  adj_wxyz = T(2) * (adj_q - q * q.dot(adj_q)) / norm;
}

/// A point in the camera frame and the rows of the pinhole projection's Jacobian in world axes, taken at x/z and y/z
/// held inside the widened frustum.
template <class T>
struct ProjectedPoint {
  Vec3<T> p;                 ///< in the camera frame
  T x, y;                    ///< p_x / p_z, p_y / p_z
  bool inside_x, inside_y;   ///< whether the bounds leave x and y as they are
  T held_x, held_y;
  Vec3<T> jx, jy;            ///< du/dposition, dv/dposition
};

template <class T>
HOST_DEVICE ProjectedPoint<T> project_point(const View<T>& view, const Vec3<T>& position) {
  ProjectedPoint<T> at;
  at.p = view.R * position + view.t;
  at.x = at.p[0] / at.p[2], at.y = at.p[1] / at.p[2];
  at.inside_x = at.x >= view.low_x && at.x <= view.high_x;
  at.inside_y = at.y >= view.low_y && at.y <= view.high_y;
  at.held_x = at.inside_x ? at.x : at.x < view.low_x ? view.low_x : view.high_x;
  at.held_y = at.inside_y ? at.y : at.y < view.low_y ? view.low_y : view.high_y;
  at.jx = (view.R.row(0) - at.held_x * view.R.row(2)).transpose() * (view.fx / at.p[2]);
  at.jy = (view.R.row(1) - at.held_y * view.R.row(2)).transpose() * (view.fy / at.p[2]);
  return at;
}

/// Elliptical weighted average projection (Zwicker et al. 2001, eq. 31): covariance2D = J W A (J W A)^T with the
/// Jacobian J of the pinhole projection at the mean.  False when the Gaussian is not drawn: nearer than kNear, or not
/// finite.  The determinant is summed from non-negative terms (Binet and Cauchy), so that thin splats keep theirs.
template <class T>
HOST_DEVICE bool project(const View<T>& view, const Vec3<T>& position, const Mat3<T>& A, Footprint<T>& out) {
  const ProjectedPoint<T> at = project_point(view, position);
  if (!(at.p[2] > T(splat::kNear))) return false;
  out.u = view.fx * at.x + view.cx, out.v = view.fy * at.y + view.cy, out.depth = at.p[2];
  const Vec3<T> mx = A.transpose() * at.jx, my = A.transpose() * at.jy;
  const T blur = T(splat::kScreenVariance), sharp = mx.cross(my).squaredNorm();
  const T xx = mx.squaredNorm(), yy = my.squaredNorm();
  out.xx = xx + blur, out.yy = yy + blur, out.xy = mx.dot(my);
  out.determinant = sharp + blur * (xx + yy) + blur * blur;
  const T ratio = sharp / out.determinant;
  out.compensation = std::sqrt(ratio > T(splat::kMinCompensation) ? ratio : T(splat::kMinCompensation));
  // One comparison that is false for infinity and for NaN anywhere in the footprint.
  return std::isfinite(out.u + out.v + out.depth + out.determinant / out.yy);
}

/// Derivatives with respect to the camera, as free entries of R, t and centre.
template <class T>
struct ViewGradient {
  Mat3<T> R = Mat3<T>::Zero();
  Vec3<T> t = Vec3<T>::Zero(), centre = Vec3<T>::Zero();

  ViewGradient& operator+=(const ViewGradient& other) {
    R += other.R, t += other.t, centre += other.centre;
    return *this;
  }
};

/// Derivatives with respect to |mx|^2, |my|^2, mx . my and |mx x my|^2, where mx and my are the rows of J W A.
template <class T>
struct RowGradient {
  T xx, yy, xy, sharp;
};

/// They follow from compensation^2 = sharp / determinant and determinant = sharp + blur (|mx|^2 + |my|^2) + blur^2.
template <class T>
HOST_DEVICE RowGradient<T> footprint_adjoint(T sharp, const Footprint<T>& f, const Footprint<T>& adj) {
  T adj_sharp = 0, adj_determinant = adj.determinant;
  const T ratio = sharp / f.determinant;
  if (ratio > T(splat::kMinCompensation)) {
    const T adj_ratio = adj.compensation / (2 * f.compensation);
    adj_sharp = adj_ratio / f.determinant;
    adj_determinant -= adj_ratio * ratio / f.determinant;
  }
  const T blur = T(splat::kScreenVariance);
  return {adj.xx + blur * adj_determinant, adj.yy + blur * adj_determinant, adj.xy, adj_sharp + adj_determinant};
}

/// Derivatives for those of the footprint `f`, given in `adj` field by field: adds to adj_position, adj_A and adj_view.
template <class T>
HOST_DEVICE void project_adjoint(const View<T>& view, const Vec3<T>& position, const Mat3<T>& A, const Footprint<T>& f,
                                 const Footprint<T>& adj, Vec3<T>& adj_position, Mat3<T>& adj_A,
                                 ViewGradient<T>& adj_view) {
  const ProjectedPoint<T> at = project_point(view, position);
  const Vec3<T> mx = A.transpose() * at.jx, my = A.transpose() * at.jy, n = mx.cross(my);
  const RowGradient<T> row = footprint_adjoint(n.squaredNorm(), f, adj);
  const Vec3<T> adj_mx = 2 * row.xx * mx + row.xy * my + 2 * row.sharp * my.cross(n);
  const Vec3<T> adj_my = 2 * row.yy * my + row.xy * mx + 2 * row.sharp * n.cross(mx);
  adj_A += at.jx * adj_mx.transpose() + at.jy * adj_my.transpose();

  const T scale_x = view.fx / at.p[2], scale_y = view.fy / at.p[2];
  const Vec3<T> adj_jx = A * adj_mx, adj_jy = A * adj_my;
  adj_view.R.row(0) += scale_x * adj_jx.transpose();
  adj_view.R.row(1) += scale_y * adj_jy.transpose();
  adj_view.R.row(2) -= (at.held_x * scale_x * adj_jx + at.held_y * scale_y * adj_jy).transpose();
  T adj_x = view.fx * adj.u, adj_y = view.fy * adj.v;
  if (at.inside_x) adj_x -= scale_x * view.R.row(2).dot(adj_jx);
  if (at.inside_y) adj_y -= scale_y * view.R.row(2).dot(adj_jy);
  const T adj_z = adj.depth - (adj_jx.dot(at.jx) + adj_jy.dot(at.jy) + adj_x * at.x + adj_y * at.y) / at.p[2];
  const Vec3<T> adj_p(adj_x / at.p[2], adj_y / at.p[2], adj_z);
  adj_position += view.R.transpose() * adj_p;
  adj_view.R += adj_p * position.transpose();
  adj_view.t += adj_p;
}

/// Derivatives with respect to the covariance in the world, a symmetric matrix.
template <class T>
HOST_DEVICE Mat3<T> project_adjoint_covariance(const View<T>& view, const Vec3<T>& position, const Mat3<T>& A,
                                               const Footprint<T>& f, const Footprint<T>& adj) {
  const ProjectedPoint<T> at = project_point(view, position);
  const Vec3<T> mx = A.transpose() * at.jx, my = A.transpose() * at.jy;
  const RowGradient<T> row = footprint_adjoint(mx.cross(my).squaredNorm(), f, adj);
  // |mx x my|^2 = |mx|^2 |my|^2 - (mx . my)^2.
  const T adj_xx = row.xx + row.sharp * my.squaredNorm(), adj_yy = row.yy + row.sharp * mx.squaredNorm();
  const T adj_xy = T(0.5) * row.xy - row.sharp * mx.dot(my);
  const Mat3<T> cross = at.jx * at.jy.transpose();
  return adj_xx * at.jx * at.jx.transpose() + adj_yy * at.jy * at.jy.transpose() + adj_xy * (cross + cross.transpose());
}

}  // namespace pliant
