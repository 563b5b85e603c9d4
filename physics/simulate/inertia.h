#pragma once

#include <Eigen/Eigenvalues>

#include "gaussians/base/types.h"

namespace pliant {

constexpr double kLeastInertia = 1e-6;  ///< of the trace of its tensor, that mass needs to turn as its torque says

/// Angular acceleration b [1/s^2] that `torque` [N m] gives to mass with the tensor of inertia `inertia` [kg m^2],
/// symmetric, both about its centre: I b = torque.  Mass on a line has no inertia about it, and the part of a torque
/// along it does nothing: b minimizes |I b - torque|^2 + c^2 |b|^2, c = kLeastInertia tr I (Tikhonov), which differs
/// from I^-1 torque only where the mass lies within about a thousandth of its length from a line.
inline Vec3d angular_acceleration(const Mat3d& inertia, const Vec3d& torque) {
  const double c = kLeastInertia * inertia.trace();
  if (!(c > 0)) return Vec3d::Zero();  // all in one point
  const Eigen::SelfAdjointEigenSolver<Mat3d> of(inertia);
  const Mat3d& Q = of.eigenvectors();
  const Eigen::Array3d lambda = of.eigenvalues();
  const Vec3d along = Q.transpose() * torque;
  return Q * (lambda / (lambda.square() + c * c) * along.array()).matrix();
}
/// Adds to `adj_inertia` and `adj_torque` the derivatives of a scalar from that with respect to the acceleration.
inline void angular_acceleration_adjoint(const Mat3d& inertia, const Vec3d& torque, const Vec3d& adj_acceleration,
                                         Mat3d& adj_inertia, Vec3d& adj_torque) {
  const double c = kLeastInertia * inertia.trace();
  if (!(c > 0)) return;
  const Eigen::SelfAdjointEigenSolver<Mat3d> of(inertia);
  const Mat3d& Q = of.eigenvectors();
  const Eigen::Array3d lambda = of.eigenvalues(), square = lambda.square() + c * c;
  const Vec3d along = Q.transpose() * torque, adj_along = Q.transpose() * adj_acceleration;
  adj_torque += Q * (lambda / square * adj_along.array()).matrix();
  // Of a function g of a matrix by its eigenvalues (Daleckii and Krein 1965): (g_i - g_j) / (lambda_i - lambda_j).
  Mat3d by = adj_along * along.transpose();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) by(i, j) *= (c * c - lambda[i] * lambda[j]) / (square[i] * square[j]);
  const double by_c = -2 * c * (lambda / square.square() * adj_along.array() * along.array()).sum();
  adj_inertia += Q * by * Q.transpose() + kLeastInertia * by_c * Mat3d::Identity();
}

}  // namespace pliant
