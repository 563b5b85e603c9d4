#pragma once

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/portable.h"

namespace pliant {

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

}  // namespace pliant
