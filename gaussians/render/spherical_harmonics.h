#pragma once

#include <Eigen/LU>

#include "gaussians/base/portable.h"
#include "gaussians/base/types.h"

namespace pliant {

constexpr int kMaxShCount = 16;

/// Real spherical harmonics of degree 0..3 at the unit direction d, [(degree + 1)^2], in the order and with the signs
/// of 3DGS files.
template <class T>
HOST_DEVICE void sh_basis(int degree, const Vec3<T>& d, T* basis) {
  basis[0] = T(0.28209479177387814);
  if (degree < 1) return;
  const T x = d[0], y = d[1], z = d[2];
  const T k1 = T(0.4886025119029199);
  basis[1] = -k1 * y, basis[2] = k1 * z, basis[3] = -k1 * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z, k2 = T(1.0925484305920792);
  basis[4] = k2 * x * y;
  basis[5] = -k2 * y * z;
  basis[6] = T(0.31539156525252005) * (2 * zz - xx - yy);
  basis[7] = -k2 * x * z;
  basis[8] = T(0.5462742152960396) * (xx - yy);
  if (degree < 3) return;
  const T k3 = T(0.5900435899266435), k4 = T(0.4570457994644658);
  basis[9] = -k3 * y * (3 * xx - yy);
  basis[10] = T(2.890611442640554) * x * y * z;
  basis[11] = -k4 * y * (4 * zz - xx - yy);
  basis[12] = T(0.3731763325901154) * z * (2 * zz - 3 * xx - 3 * yy);
  basis[13] = -k4 * x * (4 * zz - xx - yy);
  basis[14] = T(1.445305721320277) * z * (xx - yy);
  basis[15] = -k3 * x * (xx - 3 * yy);
}

/// adj_d = sum of adj_basis[k] d basis[k] / d d, with the three components of d taken as independent.
template <class T>
HOST_DEVICE void sh_basis_adjoint(int degree, const Vec3<T>& d, const T* adj_basis, Vec3<T>& adj_d) {
  const T* b = adj_basis;
  adj_d.setZero();
  if (degree < 1) return;
  const T x = d[0], y = d[1], z = d[2];
  const T k1 = T(0.4886025119029199);
  adj_d = k1 * Vec3<T>(-b[3], -b[1], b[2]);
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z, k2 = T(1.0925484305920792);
  const T zonal = T(0.31539156525252005) * b[6], k8 = T(0.5462742152960396) * b[8];
  adj_d[0] += k2 * (y * b[4] - z * b[7]) + 2 * x * (k8 - zonal);
  adj_d[1] += k2 * (x * b[4] - z * b[5]) - 2 * y * (k8 + zonal);
  adj_d[2] += -k2 * (y * b[5] + x * b[7]) + 4 * z * zonal;
  if (degree < 3) return;
  const T k3 = T(0.5900435899266435), k4 = T(0.4570457994644658);
  const T k10 = T(2.890611442640554) * b[10], k12 = T(0.3731763325901154) * b[12], k14 = T(1.445305721320277) * b[14];
  adj_d[0] += -6 * k3 * x * y * b[9] + k10 * y * z + 2 * k4 * x * y * b[11] - 6 * k12 * x * z -
              k4 * (4 * zz - 3 * xx - yy) * b[13] + 2 * k14 * x * z - 3 * k3 * (xx - yy) * b[15];
  adj_d[1] += -3 * k3 * (xx - yy) * b[9] + k10 * x * z - k4 * (4 * zz - xx - 3 * yy) * b[11] - 6 * k12 * y * z +
              2 * k4 * x * y * b[13] - 2 * k14 * y * z + 6 * k3 * x * y * b[15];
  adj_d[2] += k10 * x * y - 8 * k4 * y * z * b[11] + 3 * k12 * (2 * zz - xx - yy) - 8 * k4 * x * z * b[13] +
              k14 * (xx - yy);
}

/// Colour seen along the unit direction d (from the camera to the Gaussian): max(0, 0.5 + sum of basis * sh).
/// sh [(degree + 1)^2, 3].
template <class T, class S>
HOST_DEVICE Vec3<T> sh_color(int degree, const S* sh, const Vec3<T>& d) {
  T basis[kMaxShCount];
  sh_basis(degree, d, basis);
  Vec3<T> color(T(0.5), T(0.5), T(0.5));
  for (int k = 0; k < (degree + 1) * (degree + 1); ++k)
    for (int c = 0; c < 3; ++c) color[c] += basis[k] * T(sh[3 * k + c]);
  return color.cwiseMax(T(0));
}

/// Writes adj_sh [(degree + 1)^2, 3] and adj_d, the derivatives with respect to the coefficients and to d (its three
/// components taken as independent).  Nothing flows through a colour that is clamped at 0.
template <class T, class S>
HOST_DEVICE void sh_color_adjoint(int degree, const S* sh, const Vec3<T>& d, const Vec3<T>& adj_color, T* adj_sh,
                                  Vec3<T>& adj_d) {
  T basis[kMaxShCount], adj_basis[kMaxShCount];
  sh_basis(degree, d, basis);
  const Vec3<T> color = sh_color(degree, sh, d);
  Vec3<T> flow;
  for (int c = 0; c < 3; ++c) flow[c] = color[c] > T(0) ? adj_color[c] : T(0);
  for (int k = 0; k < (degree + 1) * (degree + 1); ++k) {
    adj_basis[k] = T(0);
    for (int c = 0; c < 3; ++c) {
      adj_sh[3 * k + c] = basis[k] * flow[c];
      adj_basis[k] += T(sh[3 * k + c]) * flow[c];
    }
  }
  sh_basis_adjoint(degree, d, adj_basis, adj_d);
}

/// Rotation of coefficients: the rotated function at d is the original at R^T d.  A band of degree l is fixed by its
/// values at 2 l + 1 directions d_k in general position, so that rotated = B^-1 [Y(R^T d_k) sh], B_kj = Y_j(d_k):
/// exact, without recursion.  One object serves all Gaussians; it holds B^-1.
template <class T>
class ShRotation {
 public:
  ShRotation() {
    inverse2_ = basis_at_directions<5>(kDirections2, 2).inverse().template cast<T>();
    inverse3_ = basis_at_directions<7>(kDirections3, 3).inverse().template cast<T>();
  }

  /// Rotates sh [(degree + 1)^2, 3] in place; the constant band is left as it is.
  template <class S>
  HOST_DEVICE void apply(const Mat3<T>& R, int degree, S* sh) const {
    if (degree >= 1) {
      // Degree 1 is the vector field (-y, z, -x).
      for (int c = 0; c < 3; ++c) {
        const Vec3<T> v = R * Vec3<T>(-sh[9 + c], -sh[3 + c], sh[6 + c]);
        sh[3 + c] = S(-v[1]), sh[6 + c] = S(v[2]), sh[9 + c] = S(-v[0]);
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

  template <int n>
  static Eigen::Matrix<double, n, n> basis_at_directions(const int (&directions)[n][3], int degree) {
    Eigen::Matrix<double, n, n> B;
    for (int k = 0; k < n; ++k) {
      double basis[kMaxShCount];
      sh_basis<double>(degree, Vec3d(directions[k][0], directions[k][1], directions[k][2]).normalized(), basis);
      for (int j = 0; j < n; ++j) B(k, j) = basis[degree * degree + j];
    }
    return B;
  }

  template <int n, class S>
  HOST_DEVICE static void rotate_band(const Mat3<T>& R, const int (&directions)[n][3],
                                      const Eigen::Matrix<T, n, n>& inverse, S* sh) {
    constexpr int degree = (n - 1) / 2;
    T value[n][3];
    for (int k = 0; k < n; ++k) {
      T basis[kMaxShCount];
      const Vec3<T> d(T(directions[k][0]), T(directions[k][1]), T(directions[k][2]));
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
