#pragma once

#include "physics/mpm/kernels/record_packs.h"

// Kirchhoff stress tau = P F^T of packs of particles as xx, yy, zz, yz, xz, xy; F row-major.  The functions return the
// lanes (as bits) for which the fast way is not safe.

namespace pliant::PLIANT_ISA {

/// Below this determinant a deformation gradient is left to the exact function: there the neo-Hookean logarithm ends.
constexpr double kLeastDeterminant = 1.01e-3;

/// Cofactors c of X and its determinant.
template <class T>
INLINE Pack<T> cofactors(const Pack<T>* X, Pack<T>* c) {
  const auto minor = [&](int a, int b, int d, int e) { return fma(X[a], X[b], -(X[d] * X[e])); };
  c[0] = minor(4, 8, 5, 7);
  c[1] = minor(5, 6, 3, 8);
  c[2] = minor(3, 7, 4, 6);
  c[3] = minor(2, 7, 1, 8);
  c[4] = minor(0, 8, 2, 6);
  c[5] = minor(1, 6, 0, 7);
  c[6] = minor(1, 5, 2, 4);
  c[7] = minor(2, 3, 0, 5);
  c[8] = minor(0, 4, 1, 3);
  return fma(X[2], c[2], fma(X[1], c[1], X[0] * c[0]));
}

/// The rotation R of F = R S by Newton's iteration X <- (X + X^-T) / 2 (Higham 1986), and J = det F.
template <class T>
INLINE uint32_t rotation(const Pack<T>* F, Pack<T>* X, Pack<T>& J) {
  // After a step all singular values are at least 1, so that det X - 1 bounds their distance from 1; the next step
  // squares and halves it.
  const T near = sizeof(T) == 4 ? T(3e-4) : T(1e-8);
  constexpr int kMostSteps = 8;
  Pack<T> c[9];
  for (int k = 0; k < 9; ++k) X[k] = F[k];
  J = cofactors<T>(X, c);
  Pack<T> determinant = J;
  const auto safe = J > all<Pack<T>>(T(kLeastDeterminant));
  uint32_t far = lane_bits(~safe);
  for (int step = 0;; ++step) {
    const Pack<T> inverse = T(0.5) / determinant;
    for (int k = 0; k < 9; ++k) X[k] = fma(inverse, c[k], T(0.5) * X[k]);
    if (step > 0 && (far == 0 || step == kMostSteps)) break;
    determinant = cofactors<T>(X, c);
    far = lane_bits(safe & ~(determinant < all<Pack<T>>(T(1) + near)));
  }
  return lane_bits(~safe) | far;
}

/// tau = 2 mu (F - R) F^T + lambda (J - 1) J I.
template <class T>
INLINE void fixed_corotated_of(const Pack<T>* F, const Pack<T>* R, Pack<T> J, Pack<T> mu, Pack<T> lambda,
                               Pack<T>* tau) {
  Pack<T> D[9];
  for (int k = 0; k < 9; ++k) D[k] = F[k] - R[k];
  const auto row = [&](int i, int j) {
    return fma(D[3 * i + 2], F[3 * j + 2], fma(D[3 * i + 1], F[3 * j + 1], D[3 * i] * F[3 * j]));
  };
  const Pack<T> mu2 = mu + mu, pressure = lambda * (J - T(1)) * J;
  for (int i = 0; i < 3; ++i) tau[i] = fma(mu2, row(i, i), pressure);
  // (F - R) F^T is symmetric up to rounding; the mean of both sides keeps angular momentum.
  tau[3] = mu * (row(1, 2) + row(2, 1));
  tau[4] = mu * (row(0, 2) + row(2, 0));
  tau[5] = mu * (row(0, 1) + row(1, 0));
}
template <class T>
INLINE uint32_t fixed_corotated(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, Pack<T>* tau) {
  Pack<T> R[9], J;
  const uint32_t unsafe = rotation<T>(F, R, J);
  fixed_corotated_of<T>(F, R, J, mu, lambda, tau);
  return unsafe;
}

/// tau = mu (F F^T - I) + lambda log(J) I.
template <class T>
INLINE uint32_t neo_hookean(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, Pack<T>* tau) {
  const auto row = [&](int i, int j) {
    return fma(F[3 * i + 2], F[3 * j + 2], fma(F[3 * i + 1], F[3 * j + 1], F[3 * i] * F[3 * j]));
  };
  Pack<T> c[9];
  const Pack<T> J = cofactors<T>(F, c);
  const Pack<T> xx = row(0, 0), yy = row(1, 1), zz = row(2, 2);
  const auto safe = (J > all<Pack<T>>(T(kLeastDeterminant))) & (xx + yy + zz < all<Pack<T>>(T(1e6)));
  const Pack<T> pressure = lambda * (T(0.693147180559945309) * logarithm2(J));
  tau[0] = fma(mu, xx - T(1), pressure);
  tau[1] = fma(mu, yy - T(1), pressure);
  tau[2] = fma(mu, zz - T(1), pressure);
  tau[3] = mu * row(1, 2);
  tau[4] = mu * row(0, 2);
  tau[5] = mu * row(0, 1);
  return lane_bits(~safe);
}

/// P = 2 mu (F - R) + lambda (J - 1) cof F.
template <class T>
INLINE void fixed_corotated_piola_of(const Pack<T>* F, const Pack<T>* R, Pack<T> mu, Pack<T> lambda, Pack<T>* P) {
  Pack<T> cof[9];
  const Pack<T> J = cofactors<T>(F, cof), mu2 = mu + mu, pressure = lambda * (J - T(1));
  for (int k = 0; k < 9; ++k) P[k] = fma(mu2, F[k] - R[k], pressure * cof[k]);
}

/// P = mu F + (lambda log(J) - mu) / J cof F.
template <class T>
INLINE uint32_t neo_hookean_piola(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, Pack<T>* P) {
  Pack<T> cof[9], square{};
  const Pack<T> J = cofactors<T>(F, cof);
  for (int k = 0; k < 9; ++k) square = fma(F[k], F[k], square);
  const auto safe = (J > all<Pack<T>>(T(kLeastDeterminant))) & (square < all<Pack<T>>(T(1e6)));
  const Pack<T> pressure = (lambda * (T(0.693147180559945309) * logarithm2(J)) - mu) / J;
  for (int k = 0; k < 9; ++k) P[k] = fma(mu, F[k], pressure * cof[k]);
  return lane_bits(~safe);
}

/// Replaces the stress of the lanes `unsafe` by that of `exact_stress`.
template <class T>
__attribute__((noinline)) void repair_stress(uint32_t unsafe, StressKind kind, const Pack<T>* F, const Pack<T>& mu,
                                             const Pack<T>& lambda,
                                             void (*exact_stress)(StressKind, const T*, T, T, T*), Pack<T>* tau) {
  for (int l = 0; l < kLanes; ++l) {
    if ((unsafe >> l & 1) == 0) continue;
    T one_F[9], one[6];
    for (int k = 0; k < 9; ++k) one_F[k] = F[k][l];
    exact_stress(kind, one_F, mu[l], lambda[l], one);
    for (int k = 0; k < 6; ++k) tau[k][l] = one[k];
  }
}

template <class T>
INLINE void pack_stress(StressKind kind, const Pack<T>* F, Pack<T> mu, Pack<T> lambda,
                        void (*exact_stress)(StressKind, const T*, T, T, T*), Pack<T>* tau) {
  const uint32_t unsafe =
      kind == StressKind::kFixedCorotated ? fixed_corotated<T>(F, mu, lambda, tau) : neo_hookean<T>(F, mu, lambda, tau);
  if (__builtin_expect(unsafe != 0, 0)) repair_stress<T>(unsafe, kind, F, mu, lambda, exact_stress, tau);
}

template <class T>
__attribute__((noinline)) void repair_piola(uint32_t unsafe, StressKind kind, const Pack<T>* F, const Pack<T>& mu,
                                            const Pack<T>& lambda, void (*exact_piola)(StressKind, const T*, T, T, T*),
                                            Pack<T>* P) {
  for (int l = 0; l < kLanes; ++l) {
    if ((unsafe >> l & 1) == 0) continue;
    T one_F[9], one[9];
    for (int k = 0; k < 9; ++k) one_F[k] = F[k][l];
    exact_piola(kind, one_F, mu[l], lambda[l], one);
    for (int k = 0; k < 9; ++k) P[k][l] = one[k];
  }
}

template <class T>
INLINE void pack_piola(StressKind kind, const Pack<T>* F, Pack<T> mu, Pack<T> lambda,
                       void (*exact_piola)(StressKind, const T*, T, T, T*), Pack<T>* P) {
  uint32_t unsafe;
  if (kind == StressKind::kNeoHookean) {
    unsafe = neo_hookean_piola<T>(F, mu, lambda, P);
  } else {
    Pack<T> R[9], J;
    unsafe = rotation<T>(F, R, J);
    fixed_corotated_piola_of<T>(F, R, mu, lambda, P);
  }
  if (__builtin_expect(unsafe != 0, 0)) repair_piola<T>(unsafe, kind, F, mu, lambda, exact_piola, P);
}

/// out = A B, with transposes where asked for.
template <bool kTransposeA, bool kTransposeB, class T>
INLINE void multiply(const Pack<T>* A, const Pack<T>* B, Pack<T>* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      Pack<T> sum{};
      for (int k = 0; k < 3; ++k)
        sum = fma(A[kTransposeA ? 3 * k + i : 3 * i + k], B[kTransposeB ? 3 * j + k : 3 * k + j], sum);
      out[3 * i + j] = sum;
    }
}

/// F^-1, zero where F is nearly flat or inverted.
template <class T>
INLINE void safe_inverse(const Pack<T>* F, Pack<T>* out) {
  Pack<T> cof[9];
  const Pack<T> J = cofactors<T>(F, cof);
  const auto safe = J > all<Pack<T>>(T(kLeastDeterminant));
  const Pack<T> inverse = safe ? T(1) / J : Pack<T>{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[3 * i + j] = cof[3 * j + i] * inverse;
}

template <class T>
void stress_of(StressKind kind, int count, const T* F, const T* mu, const T* lambda,
               void (*exact_stress)(StressKind, const T*, T, T, T*), T* tau) {
  for (int first = 0; first < count; first += kLanes) {
    Pack<T> f[9], m{}, l{}, t[6];
    const auto at = [&](int lane) { return first + lane < count ? first + lane : count - 1; };
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int k = 0; k < 9; ++k) f[k][lane] = F[9 * at(lane) + k];
      m[lane] = mu[at(lane)];
      l[lane] = lambda[at(lane)];
    }
    pack_stress<T>(kind, f, m, l, exact_stress, t);
    for (int lane = 0; lane < kLanes; ++lane)
      for (int k = 0; k < 6; ++k) tau[6 * at(lane) + k] = t[k][lane];
  }
}

}  // namespace pliant::PLIANT_ISA
