#pragma once

#include "physics/mpm/kernels/elastic_run.h"
#include "physics/mpm/kernels/stress_adjoint_kernels.h"

// First Piola-Kirchhoff stress backwards: from A = dL/dP, row-major like F.

namespace pliant::PLIANT_ISA {

/// Adds scale times the derivative of cof(F) in the direction A, which is its own adjoint.
template <class T>
INLINE void add_cofactor_derivative(const Pack<T>* F, const Pack<T>* A, Pack<T> scale, Pack<T>* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3 * 3, b = (i + 2) % 3 * 3, c = (j + 1) % 3, d = (j + 2) % 3;
      const Pack<T> plus = fma(F[a + c], A[b + d], A[a + c] * F[b + d]),
                    minus = fma(F[a + d], A[b + c], A[a + d] * F[b + c]);
      out[3 * i + j] = fma(scale, plus - minus, out[3 * i + j]);
    }
}

/// P = 2 mu (F - R) + lambda (J - 1) cof F.
template <class T>
INLINE uint32_t fixed_corotated_piola_adjoint(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, const Pack<T>* A,
                                              StressAdjointPack<T>& by) {
  Pack<T> R[9], cof[9], dR[9], J, along{};
  uint32_t unsafe = rotation<T>(F, R, J);
  unsafe |= rotation_derivative<T>(F, R, A, dR);
  cofactors<T>(F, cof);
  for (int k = 0; k < 9; ++k) along = fma(A[k], cof[k], along);
  const Pack<T> mu2 = mu + mu, volume = lambda * along;
  by.mu = Pack<T>{};
  for (int k = 0; k < 9; ++k) {
    by.F[k] = fma(mu2, A[k] - dR[k], volume * cof[k]);
    by.mu = fma(A[k], F[k] - R[k], by.mu);
  }
  add_cofactor_derivative<T>(F, A, lambda * (J - T(1)), by.F);
  by.mu += by.mu;
  by.lambda = (J - T(1)) * along;
  return unsafe;
}

/// P = mu F + (lambda log(J) - mu) / J cof F.
template <class T>
INLINE uint32_t neo_hookean_piola_adjoint(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, const Pack<T>* A,
                                          StressAdjointPack<T>& by) {
  Pack<T> cof[9], along{};
  const Pack<T> J = cofactors<T>(F, cof), inverse = T(1) / J, log_J = T(0.693147180559945309) * logarithm2(J);
  for (int k = 0; k < 9; ++k) along = fma(A[k], cof[k], along);
  const Pack<T> pressure = fma(lambda, log_J, -mu) * inverse, volume = (lambda * inverse - pressure) * inverse * along;
  by.mu = -along * inverse;
  for (int k = 0; k < 9; ++k) {
    by.F[k] = fma(mu, A[k], volume * cof[k]);
    by.mu = fma(A[k], F[k], by.mu);
  }
  add_cofactor_derivative<T>(F, A, pressure, by.F);
  by.lambda = log_J * inverse * along;
  return lane_bits(~(J > all<Pack<T>>(T(kLeastDeterminant))));
}

/// Replaces the derivatives of the lanes `unsafe` by the exact ones.
template <class T>
INLINE void repair_piola_adjoint(uint32_t unsafe, const ElasticAdjointRun<T>& run, StressKind law, const Pack<T>* F,
                                 Pack<T> mu, Pack<T> lambda, const Pack<T>* A, StressAdjointPack<T>& by) {
  for (uint32_t bits = unsafe; __builtin_expect(bits != 0, 0); bits &= bits - 1) {
    const int l = __builtin_ctz(bits);
    T one_F[9], one_A[9], by_F[9], by_lame[2];
    for (int k = 0; k < 9; ++k) one_F[k] = F[k][l];
    for (int k = 0; k < 9; ++k) one_A[k] = A[k][l];
    run.exact_piola_adjoint(law, one_F, mu[l], lambda[l], one_A, by_F, by_lame);
    for (int k = 0; k < 9; ++k) by.F[k][l] = by_F[k];
    by.mu[l] = by_lame[0];
    by.lambda[l] = by_lame[1];
  }
}

/// Of one law, exact where the fast way is not safe.
template <class T>
INLINE void law_piola_adjoint(const ElasticAdjointRun<T>& run, StressKind law, const Pack<T>* F, Pack<T> mu,
                              Pack<T> lambda, const Pack<T>* A, StressAdjointPack<T>& by) {
  const uint32_t unsafe = law == StressKind::kNeoHookean ? neo_hookean_piola_adjoint<T>(F, mu, lambda, A, by)
                                                         : fixed_corotated_piola_adjoint<T>(F, mu, lambda, A, by);
  repair_piola_adjoint<T>(unsafe, run, law, F, mu, lambda, A, by);
}

/// What the viscous part of total_piola says: derivatives by dF are added to by_dF, by the two viscosities returned.
template <class T>
struct ViscosityAdjointPack {
  Pack<T> shear, bulk;
};
template <class T>
INLINE ViscosityAdjointPack<T> viscous_piola_adjoint(const Pack<T>* F, const Pack<T>* dF, Pack<T> shear, Pack<T> bulk,
                                                     const Pack<T>* A, Pack<T>* by_F, Pack<T>* by_dF) {
  Pack<T> inverse[9], L[9], tau[9], AI[9], S[9], by_L[9], by_inverse[9], part[9];
  safe_inverse<T>(F, inverse);
  multiply<false, false, T>(dF, inverse, L);
  const Pack<T> trace = L[0] + L[4] + L[8];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) tau[3 * i + j] = shear * (L[3 * i + j] + L[3 * j + i]);
  for (int k = 0; k < 9; k += 4) tau[k] += bulk * trace;
  // P = tau F^-T.
  multiply<false, false, T>(A, inverse, AI);
  multiply<true, false, T>(A, tau, by_inverse);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) S[3 * i + j] = T(0.5) * (AI[3 * i + j] + AI[3 * j + i]);
  const Pack<T> S_trace = S[0] + S[4] + S[8];
  ViscosityAdjointPack<T> by{Pack<T>{}, S_trace * trace};
  for (int k = 0; k < 9; ++k) {
    by.shear = fma(S[k], L[k], by.shear);
    by_L[k] = (shear + shear) * S[k];
  }
  by.shear += by.shear;
  for (int k = 0; k < 9; k += 4) by_L[k] += bulk * S_trace;
  // L = dF F^-1.
  multiply<false, true, T>(by_L, inverse, part);
  for (int k = 0; k < 9; ++k) by_dF[k] += part[k];
  multiply<true, false, T>(dF, by_L, part);
  for (int k = 0; k < 9; ++k) by_inverse[k] += part[k];
  // d(F^-1) = -F^-1 dF F^-1.
  multiply<true, false, T>(inverse, by_inverse, part);
  multiply<false, true, T>(part, inverse, by_inverse);
  for (int k = 0; k < 9; ++k) by_F[k] -= by_inverse[k];
  return by;
}

}  // namespace pliant::PLIANT_ISA
