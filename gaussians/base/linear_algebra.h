#pragma once

#include "gaussians/base/types.h"

namespace pliant {

// Decompositions of Eigen, compiled once: every file that spells one out compiles it anew.

struct SymmetricEigen {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< of unit length, a column each
};
/// Eigenvalues and eigenvectors of a symmetric matrix [n, n].
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A);

struct SymmetricEigen3 {
  Vec3d values;   ///< ascending
  Mat3d vectors;  ///< of unit length, a column each
};
SymmetricEigen3 symmetric_eigen3(const Mat3d& A);

/// x [n, m] with A x = b for a symmetric, semidefinite A [n, n], by LDL^T with pivots.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b);

/// The rotation by the smallest angle that turns the unit vector `from` to the unit vector `to`.
template <class T>
Mat3<T> shortest_rotation(const Vec3<T>& from, const Vec3<T>& to);  // float, double

}  // namespace pliant
