#pragma once

#include "physics/mpm/kernels/stress_kernels.h"

// Kirchhoff stress backwards: S = dL/dtau, symmetric, as xx, yy, zz, yz, xz, xy with off-diagonal entries counted once
// per side; F row-major.  The functions return the lanes for which the fast way is not safe.

namespace pliant::PLIANT_ISA {

template <class T>
struct StressAdjointPack {
  Pack<T> F[9], mu, lambda;  ///< derivatives
};

/// out = S F.
template <class T>
INLINE void symmetric_times(const Pack<T>* S, const Pack<T>* F, Pack<T>* out) {
  const int at[9] = {0, 5, 4, 5, 1, 3, 4, 3, 2};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = fma(S[at[3 * i + 2]], F[6 + j], fma(S[at[3 * i + 1]], F[3 + j], S[at[3 * i]] * F[j]));
}

/// Column i of A times column j of B.
template <class T>
INLINE Pack<T> columns(const Pack<T>* A, int i, const Pack<T>* B, int j) {
  return fma(A[6 + i], B[6 + j], fma(A[3 + i], B[3 + j], A[i] * B[j]));
}

/// dR = R [w], (tr(U) I - U) w = axial(R^T A - A^T R), U = R^T F: the derivative of the rotation R of F in the
/// direction A, which is its own adjoint.  Returns the lanes for which tr(U) I - U is nearly singular.
template <class T>
INLINE uint32_t rotation_derivative(const Pack<T>* F, const Pack<T>* R, const Pack<T>* A, Pack<T>* dR) {
  // M = tr(U) I - U of the symmetric U; near 8 at rest.
  const Pack<T> u0 = columns<T>(R, 0, F, 0), u1 = columns<T>(R, 1, F, 1), u2 = columns<T>(R, 2, F, 2);
  const Pack<T> m01 = -columns<T>(R, 0, F, 1), m02 = -columns<T>(R, 0, F, 2), m12 = -columns<T>(R, 1, F, 2);
  const Pack<T> m00 = u1 + u2, m11 = u0 + u2, m22 = u0 + u1;
  const Pack<T> t0 = columns<T>(R, 2, A, 1) - columns<T>(R, 1, A, 2);
  const Pack<T> t1 = columns<T>(R, 0, A, 2) - columns<T>(R, 2, A, 0);
  const Pack<T> t2 = columns<T>(R, 1, A, 0) - columns<T>(R, 0, A, 1);
  const Pack<T> c00 = m11 * m22 - m12 * m12, c01 = m02 * m12 - m01 * m22, c02 = m01 * m12 - m02 * m11;
  const Pack<T> c11 = m00 * m22 - m02 * m02, c12 = m01 * m02 - m00 * m12, c22 = m00 * m11 - m01 * m01;
  const Pack<T> determinant = m00 * c00 + m01 * c01 + m02 * c02;
  const Pack<T> inverse = T(1) / determinant;
  const Pack<T> w0 = (c00 * t0 + c01 * t1 + c02 * t2) * inverse, w1 = (c01 * t0 + c11 * t1 + c12 * t2) * inverse,
                w2 = (c02 * t0 + c12 * t1 + c22 * t2) * inverse;
  for (int i = 0; i < 3; ++i) {
    const Pack<T>* r = R + 3 * i;
    dR[3 * i] = r[1] * w2 - r[2] * w1;
    dR[3 * i + 1] = r[2] * w0 - r[0] * w2;
    dR[3 * i + 2] = r[0] * w1 - r[1] * w0;
  }
  return lane_bits(~((determinant > all<Pack<T>>(T(1e-3))) & (determinant < all<Pack<T>>(T(1e9)))));
}

/// tau = 2 mu (F - R) F^T + lambda (J - 1) J I.
template <class T>
INLINE uint32_t fixed_corotated_adjoint(const Pack<T>* F, const Pack<T>* R, Pack<T> mu, Pack<T> lambda,
                                        const Pack<T>* S, StressAdjointPack<T>& by) {
  Pack<T> SF[9], SR[9], cof[9], dR[9];
  symmetric_times<T>(S, F, SF);
  symmetric_times<T>(S, R, SR);
  const Pack<T> J = cofactors<T>(F, cof);
  const uint32_t unsafe = rotation_derivative<T>(F, R, SF, dR);
  const Pack<T> trace = S[0] + S[1] + S[2], mu2 = mu + mu;
  const Pack<T> volume = lambda * trace * (J + J - T(1));
  by.mu = Pack<T>{};
  for (int k = 0; k < 9; ++k) {
    by.F[k] = fma(mu2, SF[k] + SF[k] - SR[k] - dR[k], volume * cof[k]);
    by.mu = fma(SF[k], F[k] - R[k], by.mu);
  }
  by.mu += by.mu;
  by.lambda = trace * (J - T(1)) * J;
  return unsafe;
}

/// tau = mu (F F^T - I) + lambda log(J) I.
template <class T>
INLINE uint32_t neo_hookean_adjoint(const Pack<T>* F, Pack<T> mu, Pack<T> lambda, const Pack<T>* S,
                                    StressAdjointPack<T>& by) {
  Pack<T> SF[9], cof[9];
  symmetric_times<T>(S, F, SF);
  const Pack<T> J = cofactors<T>(F, cof), trace = S[0] + S[1] + S[2];
  const Pack<T> volume = lambda * trace / J, mu2 = mu + mu;
  by.mu = -trace;
  for (int k = 0; k < 9; ++k) {
    by.F[k] = fma(mu2, SF[k], volume * cof[k]);
    by.mu = fma(SF[k], F[k], by.mu);
  }
  by.lambda = trace * (T(0.693147180559945309) * logarithm2(J));
  return lane_bits(~(J > all<Pack<T>>(T(kLeastDeterminant))));
}

}  // namespace pliant::PLIANT_ISA
