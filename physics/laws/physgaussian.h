#pragma once

#include "physics/laws/hencky.h"

namespace pliant {

/// Metal and foam as the released code of PhysGaussian has them: principal Kirchhoff stresses sigma_i (2 mu e_i +
/// lambda sum e), which are sigma_i times those of Hencky's law and derive from no energy.  Only for comparison.
template <class T>
struct StretchedHencky {
  T mu, lambda;

  T energy(const Mat3<T>& F) const { return Hencky<T>{mu, lambda}.energy(F); }
  Mat3<T> stress(const Mat3<T>& F) const {
    const Svd<T> s = svd(F);
    const Vec3<T> e = strain(s.sigma), tau = principal(e).cwiseProduct(s.sigma);
    const Mat3<T> half = T(0.5) * (s.U * tau.asDiagonal() * s.U.transpose());
    return half + half.transpose();
  }
  /// tau = P F^T with P = U diag(2 mu e + lambda sum e) V^T.
  LawGradient<T> stress_adjoint(const Mat3<T>& F, const Mat3<T>& adj_tau) const {
    const Svd<T> s = svd(F);
    const Vec3<T> e = strain(s.sigma), p = principal(e);
    Mat3<T> slope = Mat3<T>::Zero();
    for (int j = 0; j < 3; ++j) {
      const T e_slope = s.sigma[j] < T(kSmallestStretch) ? T(0) : 1 / s.sigma[j];
      slope.col(j).setConstant(lambda * e_slope);
      slope(j, j) += 2 * mu * e_slope;
    }
    const Mat3<T> A = T(0.5) * (adj_tau + adj_tau.transpose()), adj_P = A * F;
    const Vec3<T> by_p = (s.U.transpose() * adj_P * s.V).diagonal();
    LawGradient<T> g;
    g.F = spectral_adjoint<T>(s, p, slope, adj_P) + A * (s.U * p.asDiagonal() * s.V.transpose());
    g.mu = 2 * by_p.dot(e);
    g.lambda = by_p.sum() * e.sum();
    return g;
  }

 private:
  static Vec3<T> strain(const Vec3<T>& sigma) { return sigma.cwiseMax(T(kSmallestStretch)).array().log().matrix(); }
  Vec3<T> principal(const Vec3<T>& e) const { return ((2 * mu * e).array() + lambda * e.sum()).matrix(); }
};

/// Snow as there: no stress at all.
template <class T>
struct Stressless {
  T energy(const Mat3<T>&) const { return T(0); }
  Mat3<T> stress(const Mat3<T>&) const { return Mat3<T>::Zero(); }
  LawGradient<T> stress_adjoint(const Mat3<T>&, const Mat3<T>&) const { return {}; }
};

}  // namespace pliant
