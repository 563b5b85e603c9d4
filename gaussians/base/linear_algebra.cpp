#include "gaussians/base/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace pliant {
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen3 symmetric_eigen3(const Mat3d& A) {
  const Eigen::SelfAdjointEigenSolver<Mat3d> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& b) { return A.ldlt().solve(b); }

template <class T>
Mat3<T> shortest_rotation(const Vec3<T>& from, const Vec3<T>& to) {
  const T root = (from + to).norm();  // twice the cosine of half the angle
  // Half a turn has no axis of its own: any axis across will do.
  if (root < std::sqrt(Eigen::NumTraits<T>::epsilon()))
    return Eigen::AngleAxis<T>(T(M_PI), from.unitOrthogonal()).toRotationMatrix();
  Eigen::Quaternion<T> q;
  q.vec() = from.cross(to) / root;
  q.w() = root / 2;
  return q.toRotationMatrix();
}
template Mat3f shortest_rotation<float>(const Vec3f&, const Vec3f&);
template Mat3d shortest_rotation<double>(const Vec3d&, const Vec3d&);

}  // namespace pliant
