#pragma once

#include <algorithm>
#include <cmath>

#include "gaussians/base/polar.h"
#include "physics/laws/law.h"

namespace pliant {

/// Weakly compressible fluid: pressure p = K / gamma (J^-gamma - 1) for J < 1 (Cole 1948; Tait's form), none for J > 1:
/// a free surface carries no tension, so a jet parts instead of pulling.  tau = -J p I.  After a step F is J^(1/3) I;
/// J is remembered between 0.1 and `kLargestVolume`, below 0.1 the pressure stays that of 0.1.
/// Valid while compression stays at some per cent: K of at least 100 times density times gravity times depth.
template <class T>
struct Fluid {
  static constexpr T kSmallestVolume = T(0.1);
  static constexpr T kLargestVolume = T(1.1);
  T bulk, gamma;

  T energy(const Mat3<T>& F) const {
    const T J = F.determinant(), inside = std::max(J, kSmallestVolume);
    if (J > T(1)) return T(0);
    // Integral of -p from 1; (J^(1 - gamma) - 1) / (gamma - 1) is -ln J for gamma = 1.
    const T power = std::log(inside), e = 1 - gamma;
    const T stored = (std::abs(e * power) < T(1e-6) ? -power : -std::expm1(e * power) / e) + inside - 1;
    return bulk / gamma * stored - pressure(inside) * (J - inside);
  }

  Mat3<T> stress(const Mat3<T>& F) const {
    const T J = F.determinant();
    return -J * pressure(std::max(J, kSmallestVolume)) * Mat3<T>::Identity();
  }

  /// `mu` and `lambda` are left to the caller, who knows where K comes from; it gets dL/dK in `lambda`.
  LawGradient<T> stress_adjoint(const Mat3<T>& F, const Mat3<T>& adj_tau) const {
    const Mat3<T> C = cofactor(F);
    const T J = F.col(0).dot(C.col(0)), trace = adj_tau.trace(), p = pressure(std::max(J, kSmallestVolume));
    const T slope = J > T(1) || J < kSmallestVolume ? T(0) : -bulk * std::pow(J, -gamma - 1);
    LawGradient<T> g;
    g.F = -(p + J * slope) * trace * C;
    g.lambda = -J * p / bulk * trace;
    return g;
  }

  static void return_map(Mat3<T>& F) {
    F = std::cbrt(std::clamp(F.determinant(), kSmallestVolume, kLargestVolume)) * Mat3<T>::Identity();
  }
  static Mat3<T> return_map_adjoint(const Mat3<T>& trial_F, const Mat3<T>& adj_F) {
    const Mat3<T> C = cofactor(trial_F);
    const T J = trial_F.col(0).dot(C.col(0));
    if (J < kSmallestVolume || J > kLargestVolume) return Mat3<T>::Zero();
    const T side = std::cbrt(J);
    return adj_F.trace() / (3 * side * side) * C;
  }

 private:
  T pressure(T J) const { return J > T(1) ? T(0) : bulk / gamma * (std::pow(J, -gamma) - 1); }
};

}  // namespace pliant
