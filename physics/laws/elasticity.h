#pragma once

#include <cmath>

#include "gaussians/base/polar.h"
#include "physics/laws/material.h"
#include "physics/laws/pack.h"

namespace pliant {

/// tau = 2 mu (F - R) F^T + lambda (J - 1) J I as xx, yy, zz, yz, xz, xy, given R; F and R row-major.  S is a scalar or
/// a pack of particles.
template <class S>
inline __attribute__((always_inline)) void fixed_corotated_stress(const S* F, const S* R, const S& J, const S& mu,
                                                                  const S& lambda, S* tau) {
  S D[9], A[9];
  for (int k = 0; k < 9; ++k) D[k] = F[k] - R[k];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      A[3 * i + j] = D[3 * i] * F[3 * j] + D[3 * i + 1] * F[3 * j + 1] + D[3 * i + 2] * F[3 * j + 2];
  const S mu2 = mu + mu, pressure = lambda * (J - 1) * J;
  for (int i = 0; i < 3; ++i) tau[i] = mu2 * A[4 * i] + pressure;
  // (F - R) F^T is symmetric up to rounding; the mean of both sides keeps angular momentum.
  tau[3] = mu * (A[5] + A[7]);
  tau[4] = mu * (A[2] + A[6]);
  tau[5] = mu * (A[1] + A[3]);
}

/// Kirchhoff stress tau = P F^T [Pa] of one particle (xx, yy, zz, yz, xz, xy), for any F.
template <class T>
void kirchhoff_stress(Law law, const T* F, T mu, T lambda, T* tau) {
  const Mat3<T> matrix = Eigen::Map<const Eigen::Matrix<T, 3, 3, Eigen::RowMajor>>(F);
  switch (law) {
    case Law::kFixedCorotated: {
      const Eigen::Matrix<T, 3, 3, Eigen::RowMajor> R = polar_rotation(matrix);
      fixed_corotated_stress(F, R.data(), matrix.determinant(), mu, lambda, tau);
    }
    default: break;
  }
}

/// The same for four particles at once.  The rotation is Newton's iteration X <- (X + X^-T) / 2 with a fixed number of
/// steps; lanes in which it has not converged (singular, inverted or very stretched F) go through `kirchhoff_stress`.
template <class T>
inline void kirchhoff_stress_pack(Law law, const Pack<T>* F, const Pack<T>& mu, const Pack<T>& lambda,
                                  Pack<T>* tau) {
  using P = Pack<T>;
  constexpr int kSteps = sizeof(T) == 4 ? 4 : 6;
  // The last step's squared change bounds the error left by its square.
  const T tolerance = sizeof(T) == 4 ? T(1e-7) : T(1e-15);
  P X[9], J{}, change{};
  for (int k = 0; k < 9; ++k) X[k] = F[k];
  for (int step = 0; step < kSteps; ++step) {
    const P c[9] = {X[4] * X[8] - X[5] * X[7], X[5] * X[6] - X[3] * X[8], X[3] * X[7] - X[4] * X[6],
                    X[2] * X[7] - X[1] * X[8], X[0] * X[8] - X[2] * X[6], X[1] * X[6] - X[0] * X[7],
                    X[1] * X[5] - X[2] * X[4], X[2] * X[3] - X[0] * X[5], X[0] * X[4] - X[1] * X[3]};
    const P determinant = X[0] * c[0] + X[1] * c[1] + X[2] * c[2];
    if (step == 0) J = determinant;
    const P inverse = T(0.5) / determinant;
    change = P{};
    for (int k = 0; k < 9; ++k) {
      const P next = T(0.5) * X[k] + inverse * c[k];
      const P d = next - X[k];
      change += d * d;
      X[k] = next;
    }
  }
  fixed_corotated_stress(F, X, J, mu, lambda, tau);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (change[lane] < tolerance && J[lane] > T(0)) continue;
    T f[9];
    for (int k = 0; k < 9; ++k) f[k] = F[k][lane];
    T one[6];
    kirchhoff_stress<T>(law, f, mu[lane], lambda[lane], one);
    for (int k = 0; k < 6; ++k) tau[k][lane] = one[k];
  }
}

}  // namespace pliant
