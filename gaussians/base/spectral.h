#pragma once

#include "gaussians/base/polar.h"

namespace pliant {

namespace spectral_detail {

/// What multiplies the symmetric and the antisymmetric part of an off-diagonal pair: numerator / denominator, or the
/// limit where the denominator vanishes.  The switch balances rounding, eps / d, against the limit's error, d^2.
template <class T>
HOST_DEVICE T quotient(T numerator, T denominator, T limit, T scale) {
  const T smallest = std::cbrt(Eigen::NumTraits<T>::epsilon()) * scale;
  return std::abs(denominator) > smallest ? numerator / denominator : limit;
}

}  // namespace spectral_detail

/// Change dG of G = U diag(f(sigma)) V^T for a change dF of F = U diag(sigma) V^T, where f is isotropic (permuting
/// sigma permutes f).  f [3], slope(i, j) = d f_i / d sigma_j.  With A = U^T dF V the pair (i, j) of U^T dG V is (f_i -
/// f_j) / (sigma_i - sigma_j) times the symmetric part of A plus (f_i + f_j) / (sigma_i + sigma_j) times the
/// antisymmetric part (Stomakhin et al. 2012, section 4); where singular values are equal the quotients are derivatives
/// of f, so U and V themselves, which are not smooth there, are never differentiated.  A negative sigma is served as
/// well; where sigma_i + sigma_j = 0 the map is smooth only if f_i + f_j = 0 too, and otherwise the result is bounded.
template <class T>
HOST_DEVICE Mat3<T> spectral_derivative(const Svd<T>& svd, const Vec3<T>& f, const Mat3<T>& slope, const Mat3<T>& dF) {
  const Mat3<T> A = svd.U.transpose() * dF * svd.V;
  const Vec3<T>& s = svd.sigma;
  const T scale = s.cwiseAbs().maxCoeff();
  Mat3<T> B;
  B.diagonal() = slope * A.diagonal();
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 3; ++j) {
      const T own = slope(i, i) + slope(j, j), other = slope(i, j) + slope(j, i);
      const T difference = spectral_detail::quotient<T>(f[i] - f[j], s[i] - s[j], (own - other) / 2, scale);
      const T sum = spectral_detail::quotient<T>(f[i] + f[j], s[i] + s[j], (own + other) / 2, scale);
      const T symmetric = difference * (A(i, j) + A(j, i)) / 2, antisymmetric = sum * (A(i, j) - A(j, i)) / 2;
      B(i, j) = symmetric + antisymmetric;
      B(j, i) = symmetric - antisymmetric;
    }
  }
  return svd.U * B * svd.V.transpose();
}

/// dL/dF from dL/dG: only the coupling of singular values is transposed, the rest is its own adjoint.
template <class T>
HOST_DEVICE Mat3<T> spectral_adjoint(const Svd<T>& svd, const Vec3<T>& f, const Mat3<T>& slope, const Mat3<T>& adj_G) {
  return spectral_derivative<T>(svd, f, slope.transpose(), adj_G);
}

}  // namespace pliant
