#pragma once

#include <cmath>

#include "physics/laws/principal.h"

namespace pliant {

/// Below this principal stretch the logarithm goes on as its tangent; plastic flow lifts smaller stretches to it.
constexpr double kSmallestStretch = 0.01;

/// Psi = mu sum e_i^2 + lambda/2 (sum e_i)^2, e_i = ln sigma_i (Hencky 1928; Simo 1992 as the basis of finite
/// plasticity).
/// Valid for stretches between about 0.7 and 1.4 under load (beyond e in one direction the true stress falls again),
/// and for the elastic part of everything that flows; flat and inverted states have finite energy and are pushed back.
template <class T>
struct Hencky {
  T mu, lambda;

  T energy(const Mat3<T>& F) const {
    const Vec3<T> e = strain(svd(F).sigma).value;
    return mu * e.squaredNorm() + T(0.5) * lambda * e.sum() * e.sum();
  }

  /// Principal values 2 mu e_i + lambda sum e (times sigma_i e_i', which is 1 for the logarithm).
  Mat3<T> stress(const Mat3<T>& F) const {
    const Svd<T> s = svd(F);
    const Vec3<T> tau = principal(strain(s.sigma)).cwiseProduct(s.sigma);
    const Mat3<T> half = T(0.5) * (s.U * tau.asDiagonal() * s.U.transpose());
    return half + half.transpose();
  }

  /// tau = P F^T.
  LawGradient<T> stress_adjoint(const Mat3<T>& F, const Mat3<T>& adj_tau) const {
    const Svd<T> s = svd(F);
    const Mat3<T> A = T(0.5) * (adj_tau + adj_tau.transpose());
    LawGradient<T> g = piola_adjoint(s, A * F);
    g.F += A * (s.U * principal(strain(s.sigma)).asDiagonal() * s.V.transpose());
    return g;
  }

  /// P = dPsi/dF = U diag(p) V^T with p = dPsi/dsigma.
  Mat3<T> piola(const Mat3<T>& F) const {
    const Svd<T> s = svd(F);
    return s.U * principal(strain(s.sigma)).asDiagonal() * s.V.transpose();
  }
  LawGradient<T> piola_adjoint(const Mat3<T>& F, const Mat3<T>& adj_P) const { return piola_adjoint(svd(F), adj_P); }

 private:
  struct Strain {
    Vec3<T> value, slope, curvature;
  };
  LawGradient<T> piola_adjoint(const Svd<T>& s, const Mat3<T>& adj_P) const {
    const Strain e = strain(s.sigma);
    Mat3<T> slope = lambda * e.slope * e.slope.transpose();
    for (int i = 0; i < 3; ++i) {
      const T t = 2 * mu * e.value[i] + lambda * e.value.sum();
      slope(i, i) += 2 * mu * e.slope[i] * e.slope[i] + t * e.curvature[i];
    }
    const Vec3<T> by_p = (s.U.transpose() * adj_P * s.V).diagonal().cwiseProduct(e.slope);
    LawGradient<T> g;
    g.F = spectral_adjoint<T>(s, principal(e), slope, adj_P);
    g.mu = 2 * by_p.dot(e.value);
    g.lambda = by_p.sum() * e.value.sum();
    return g;
  }
  static Strain strain(const Vec3<T>& sigma) {
    constexpr T kSmallest = T(kSmallestStretch);
    Strain e;
    for (int i = 0; i < 3; ++i) {
      const bool tangent = sigma[i] < kSmallest;
      e.slope[i] = 1 / (tangent ? kSmallest : sigma[i]);
      e.value[i] = tangent ? std::log(kSmallest) + sigma[i] / kSmallest - 1 : std::log(sigma[i]);
      e.curvature[i] = tangent ? T(0) : -e.slope[i] * e.slope[i];
    }
    return e;
  }
  Vec3<T> principal(const Strain& e) const {
    return ((2 * mu * e.value).array() + lambda * e.value.sum()).matrix().cwiseProduct(e.slope);
  }
};

/// Logarithmic strain in its two parts, for return maps; S is a scalar or a Dual.
template <class S>
struct HenckyStrain {
  std::array<S, 3> deviator;
  S trace;
  bool lifted;  ///< a stretch was below the smallest one

  explicit HenckyStrain(const std::array<S, 3>& sigma) : trace(0), lifted(false) {
    using std::log;
    for (int i = 0; i < 3; ++i) {
      const bool low = sigma[i] < S(kSmallestStretch);
      deviator[i] = low ? S(std::log(kSmallestStretch)) : log(sigma[i]);
      lifted |= low;
      trace += deviator[i];
    }
    for (S& e : deviator) e = e - trace / S(3);
  }
  S norm() const {
    using std::sqrt;
    return sqrt(deviator[0] * deviator[0] + deviator[1] * deviator[1] + deviator[2] * deviator[2]);
  }
  /// Stretches with the deviator shrunk to `shrink` times itself.
  std::array<S, 3> stretches(const S& shrink) const {
    using std::exp;
    const S mean = trace / S(3);
    return {exp(shrink * deviator[0] + mean), exp(shrink * deviator[1] + mean), exp(shrink * deviator[2] + mean)};
  }
};

}  // namespace pliant
