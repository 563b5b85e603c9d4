#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "gaussians/base/portable.h"
#include "gaussians/base/types.h"

namespace pliant {

/// Eigenvalues (ascending) and orthonormal eigenvectors (columns) of a symmetric N x N matrix by cyclic Jacobi
/// rotations (Golub and Van Loan, section 8.5).  Only for small N; never fails, repeated eigenvalues included.
template <class T, int N>
HOST_DEVICE void symmetric_eigen(Eigen::Matrix<T, N, N> A, Eigen::Matrix<T, N, 1>& value,
                                 Eigen::Matrix<T, N, N>& vector) {
  vector.setIdentity();
  constexpr int kSweeps = 12;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    T off = 0;
    for (int p = 0; p < N; ++p)
      for (int q = p + 1; q < N; ++q) off += A(p, q) * A(p, q);
    if (!(off > A.diagonal().squaredNorm() * Eigen::NumTraits<T>::epsilon() * Eigen::NumTraits<T>::epsilon())) break;
    for (int p = 0; p < N; ++p) {
      for (int q = p + 1; q < N; ++q) {
        if (A(p, q) == T(0)) continue;
        const T theta = (A(q, q) - A(p, p)) / (2 * A(p, q));
        const T t = (theta >= T(0) ? T(1) : T(-1)) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const T c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < N; ++k) {
          const T a = A(k, p), b = A(k, q);
          A(k, p) = c * a - s * b;
          A(k, q) = s * a + c * b;
        }
        for (int k = 0; k < N; ++k) {
          const T a = A(p, k), b = A(q, k);
          A(p, k) = c * a - s * b;
          A(q, k) = s * a + c * b;
          const T u = vector(k, p), v = vector(k, q);
          vector(k, p) = c * u - s * v;
          vector(k, q) = s * u + c * v;
        }
        A(p, q) = A(q, p) = 0;
      }
    }
  }
  value = A.diagonal();
  for (int i = 0; i < N; ++i) {
    int smallest = i;
    for (int j = i + 1; j < N; ++j)
      if (value[j] < value[smallest]) smallest = j;
    if (smallest == i) continue;
    std::swap(value[i], value[smallest]);
    vector.col(i).swap(vector.col(smallest));
  }
}

/// Matrix of cofactors, det(F) F^-T.
template <class T>
HOST_DEVICE Mat3<T> cofactor(const Mat3<T>& F) {
  Mat3<T> C;
  C.col(0) = F.col(1).cross(F.col(2));
  C.col(1) = F.col(2).cross(F.col(0));
  C.col(2) = F.col(0).cross(F.col(1));
  return C;
}

/// Derivative of cofactor(F) in the direction A, which is its own adjoint.
template <class T>
HOST_DEVICE Mat3<T> cofactor_derivative(const Mat3<T>& F, const Mat3<T>& A) {
  Mat3<T> out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      out(i, j) = F(a, c) * A(b, d) + A(a, c) * F(b, d) - F(a, d) * A(b, c) - A(a, d) * F(b, c);
    }
  return out;
}

/// The rotation (det = +1) that maximises tr(R^T F), for any F: the dominant eigenvector of a symmetric 4 x 4 matrix
/// is its quaternion (Davenport; Horn 1987).  Where several rotations are equally good, one is chosen by a fixed rule;
/// F = 0 gives the identity.
template <class T>
HOST_DEVICE Mat3<T> closest_rotation(const Mat3<T>& F) {
  Eigen::Matrix<T, 4, 4> K;
  K(0, 0) = F(0, 0) + F(1, 1) + F(2, 2);
  K(1, 1) = F(0, 0) - F(1, 1) - F(2, 2);
  K(2, 2) = F(1, 1) - F(0, 0) - F(2, 2);
  K(3, 3) = F(2, 2) - F(0, 0) - F(1, 1);
  K(0, 1) = K(1, 0) = F(2, 1) - F(1, 2);
  K(0, 2) = K(2, 0) = F(0, 2) - F(2, 0);
  K(0, 3) = K(3, 0) = F(1, 0) - F(0, 1);
  K(1, 2) = K(2, 1) = F(0, 1) + F(1, 0);
  K(1, 3) = K(3, 1) = F(0, 2) + F(2, 0);
  K(2, 3) = K(3, 2) = F(1, 2) + F(2, 1);
  if (K.isZero(T(0))) return Mat3<T>::Identity();
  Eigen::Matrix<T, 4, 1> value;
  Eigen::Matrix<T, 4, 4> vector;
  symmetric_eigen<T, 4>(K, value, vector);
  const Eigen::Matrix<T, 4, 1> q = vector.col(3).normalized();
  return Eigen::Quaternion<T>(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

/// Rotation R of the polar decomposition F = R S with det R = +1 for every F: singular and inverted F are served by
/// `closest_rotation` (the reflection goes into the smallest principal stretch), the rest by Newton's iteration
/// X <- (X + X^-T) / 2 (Higham 1986), which converges quadratically.
template <class T>
HOST_DEVICE Mat3<T> polar_rotation(const Mat3<T>& F) {
  // det / |F|^3 is at most 3^-1.5 = 0.19; below this fraction a principal stretch is small against the others.
  constexpr T kWellConditioned = T(0.02);
  const T size = F.norm();
  if (!(size > T(0))) return Mat3<T>::Identity();
  Mat3<T> X = F * (T(1.7320508075688772) / size);
  Mat3<T> C = cofactor(X);
  T determinant = X.col(0).dot(C.col(0));
  if (!(determinant > kWellConditioned * T(5.196152422706632))) return closest_rotation<T>(F / size);
  const T tolerance = T(0.1) * Eigen::NumTraits<T>::epsilon();  // squared step; the next step would be its square
  for (int step = 0; step < 16; ++step) {
    const Mat3<T> next = T(0.5) * (X + C * (1 / determinant));
    const T change = (next - X).squaredNorm();
    X = next;
    if (change < tolerance) break;
    C = cofactor(X);
    determinant = X.col(0).dot(C.col(0));
  }
  return X;
}

/// Polar decomposition F = R S: R a rotation, S symmetric (indefinite when det F < 0).
template <class T>
struct Polar {
  Mat3<T> R, S;
};

template <class T>
HOST_DEVICE Polar<T> polar(const Mat3<T>& F) {
  const Mat3<T> R = polar_rotation(F), RtF = R.transpose() * F;
  return {R, T(0.5) * (RtF + RtF.transpose())};
}

/// Change dR of the rotation for a change dF.  The map dF -> dR is its own adjoint: with dL/dR in place of dF the
/// result is dL/dF.  dR = R [w], (tr(S) I - S) w = axial(R^T dF - dF^T R).
/// Undefined where two principal stretches add up to zero; there the result is bounded.
template <class T>
HOST_DEVICE Mat3<T> polar_rotation_derivative(const Polar<T>& p, const Mat3<T>& dF) {
  const Mat3<T> A = p.R.transpose() * dF;
  const Mat3<T> M = p.S.trace() * Mat3<T>::Identity() - p.S, C = cofactor(M);
  const T determinant = M.col(0).dot(C.col(0)), size = M.norm();
  const T floor = Eigen::NumTraits<T>::epsilon() * size * size * size;
  if (!(std::abs(determinant) > floor)) return Mat3<T>::Zero();
  const Vec3<T> w = C * Vec3<T>(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1)) / determinant;
  Mat3<T> W;
  W << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0;
  return p.R * W;
}

/// Singular value decomposition F = U diag(sigma) V^T with rotations U and V; sigma ascending, so that only the first
/// is negative when det F < 0 and it is the smallest in magnitude.
template <class T>
struct Svd {
  Mat3<T> U, V;
  Vec3<T> sigma;
};

template <class T>
HOST_DEVICE Svd<T> svd(const Mat3<T>& F) {
  const Polar<T> p = polar(F);
  Svd<T> out;
  symmetric_eigen<T, 3>(p.S, out.sigma, out.V);
  if (out.V.col(0).cross(out.V.col(1)).dot(out.V.col(2)) < T(0)) out.V.col(0) = -out.V.col(0);
  out.U = p.R * out.V;
  return out;
}

}  // namespace pliant
