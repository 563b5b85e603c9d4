#pragma once

#include "gaussians/base/portable.h"
#include "gaussians/base/types.h"
#include "gaussians/render/sh_basis.h"

namespace pliant {

/// The formulas of sh_basis.h for one Gaussian; d is the unit direction from the camera to it.
template <class T>
HOST_DEVICE void sh_basis(int degree, const Vec3<T>& d, T* basis) {
  sh_basis<T>(degree, d[0], d[1], d[2], basis);
}
template <class T>
HOST_DEVICE void sh_basis_adjoint(int degree, const Vec3<T>& d, const T* adj_basis, Vec3<T>& adj_d) {
  sh_basis_adjoint<T>(degree, d[0], d[1], d[2], adj_basis, adj_d.data());
}
template <class T, class S>
HOST_DEVICE Vec3<T> sh_color(int degree, const S* sh, const Vec3<T>& d) {
  Vec3<T> color;
  sh_color<T>(degree, sh, d[0], d[1], d[2], color.data());
  return color;
}
template <class T, class S>
HOST_DEVICE void sh_color_adjoint(int degree, const S* sh, const Vec3<T>& d, const Vec3<T>& adj_color, T* adj_sh,
                                  Vec3<T>& adj_d) {
  sh_color_adjoint<T>(degree, sh, d[0], d[1], d[2], adj_color.data(), adj_sh, adj_d.data());
}

/// Rotation of coefficients: the rotated function at d is the original at R^T d.  A band of degree l is fixed by its
/// values at 2 l + 1 directions d_k in general position, so that rotated = B^-1 [Y(R^T d_k) sh], B_kj = Y_j(d_k):
/// exact, without recursion.  One object serves all Gaussians; it holds B^-1.
template <class T>
class ShRotation {
 public:
  ShRotation();

  /// Rotates sh [(degree + 1)^2, 3] in place; the constant band is left as it is.
  template <class S>
  HOST_DEVICE void apply(const Mat3<T>& R, int degree, S* sh) const {
    if (degree >= 1) {
      // Degree 1 is the vector field (-y, z, -x).
      for (int c = 0; c < 3; ++c) {
        const Vec3<T> v = R * Vec3<T>(-sh[9 + c], -sh[3 + c], sh[6 + c]);
        sh[3 + c] = S(-v[1]);
        sh[6 + c] = S(v[2]);
        sh[9 + c] = S(-v[0]);
      }
    }
    if (degree >= 2) rotate_band<5>(R, kDirections2, inverse2_, sh + 12);
    if (degree >= 3) rotate_band<7>(R, kDirections3, inverse3_, sh + 27);
  }

  /// Adds to adj_R the derivative with respect to R (its nine entries taken as independent) from those with respect to
  /// the rotated coefficients.  sh: the coefficients before they are rotated.
  template <class S>
  HOST_DEVICE void apply_adjoint(const Mat3<T>& R, int degree, const S* sh, const T* adj_rotated,
                                 Mat3<T>& adj_R) const {
    if (degree >= 1) {
      for (int c = 0; c < 3; ++c) {
        const Vec3<T> u(T(-sh[9 + c]), T(-sh[3 + c]), T(sh[6 + c]));
        adj_R += Vec3<T>(-adj_rotated[9 + c], -adj_rotated[3 + c], adj_rotated[6 + c]) * u.transpose();
      }
    }
    if (degree >= 2) rotate_band_adjoint<5>(R, kDirections2, inverse2_, sh + 12, adj_rotated + 12, adj_R);
    if (degree >= 3) rotate_band_adjoint<7>(R, kDirections3, inverse3_, sh + 27, adj_rotated + 27, adj_R);
  }

 private:
  // Small integer directions whose B has a condition number below 9.
  static constexpr int kDirections2[5][3] = {{0, 2, -1}, {1, -2, -1}, {1, 2, 2}, {2, -1, 2}, {0, 0, 1}};
  static constexpr int kDirections3[7][3] = {{1, 2, 2}, {2, -1, 0}, {1, 1, -1}, {1, -1, -1},
                                             {1, 1, 0}, {2, 0, -1}, {1, -2, 2}};

  template <int n, class S>
  HOST_DEVICE static void rotate_band(const Mat3<T>& R, const int (&directions)[n][3],
                                      const Eigen::Matrix<T, n, n>& inverse, S* sh) {
    constexpr int degree = (n - 1) / 2;
    T value[n][3];
    for (int k = 0; k < n; ++k) {
      T basis[kMaxShCount];
      const Vec3<T> d{T(directions[k][0]), T(directions[k][1]), T(directions[k][2])};
      sh_basis<T>(degree, R.transpose() * d / d.norm(), basis);
      for (int c = 0; c < 3; ++c) {
        value[k][c] = 0;
        for (int j = 0; j < n; ++j) value[k][c] += basis[degree * degree + j] * T(sh[3 * j + c]);
      }
    }
    for (int j = 0; j < n; ++j) {
      for (int c = 0; c < 3; ++c) {
        T sum = 0;
        for (int k = 0; k < n; ++k) sum += inverse(j, k) * value[k][c];
        sh[3 * j + c] = S(sum);
      }
    }
  }

  template <int n, class S>
  HOST_DEVICE static void rotate_band_adjoint(const Mat3<T>& R, const int (&directions)[n][3],
                                              const Eigen::Matrix<T, n, n>& inverse, const S* sh, const T* adj_rotated,
                                              Mat3<T>& adj_R) {
    constexpr int degree = (n - 1) / 2;
    for (int k = 0; k < n; ++k) {
      Vec3<T> adj_value = Vec3<T>::Zero(), adj_back;
      for (int j = 0; j < n; ++j)
        for (int c = 0; c < 3; ++c) adj_value[c] += inverse(j, k) * adj_rotated[3 * j + c];
      T adj_basis[kMaxShCount] = {};
      for (int j = 0; j < n; ++j)
        for (int c = 0; c < 3; ++c) adj_basis[degree * degree + j] += adj_value[c] * T(sh[3 * j + c]);
      const Vec3<T> d = Vec3<T>(T(directions[k][0]), T(directions[k][1]), T(directions[k][2])).normalized();
      sh_basis_adjoint<T>(degree, R.transpose() * d, adj_basis, adj_back);
      adj_R += d * adj_back.transpose();
    }
  }

  Eigen::Matrix<T, 5, 5> inverse2_;
  Eigen::Matrix<T, 7, 7> inverse3_;
};

}  // namespace pliant
