#include "gaussians/render/spherical_harmonics.h"

#include <Eigen/LU>

namespace pliant {
namespace {

/// B^-1 for a band of degree l: B_kj = Y_j(d_k) at 2 l + 1 directions d_k.
Eigen::MatrixXd inverse_basis(int degree, const int (*directions)[3]) {
  const int n = 2 * degree + 1;
  Eigen::MatrixXd B(n, n);
  for (int k = 0; k < n; ++k) {
    double basis[kMaxShCount];
    sh_basis<double>(degree, Vec3d(directions[k][0], directions[k][1], directions[k][2]).normalized(), basis);
    for (int j = 0; j < n; ++j) B(k, j) = basis[degree * degree + j];
  }
  return B.inverse();
}

}  // namespace

template <class T>
ShRotation<T>::ShRotation()
    : inverse2_(inverse_basis(2, kDirections2).cast<T>()), inverse3_(inverse_basis(3, kDirections3).cast<T>()) {}

template class ShRotation<float>;
template class ShRotation<double>;

}  // namespace pliant
