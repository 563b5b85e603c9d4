#pragma once

#include "gaussians/base/polar.h"
#include "physics/laws/law.h"

namespace pliant {

/// Psi = mu/2 (|F|^2 - 3) - mu ln J + lambda/2 (ln J)^2 (Bonet and Wood 2008, eq. 6.27).
/// Valid for rubber at any stretch that keeps its volume roughly; below J = 0.001 the logarithm goes on as its tangent,
/// so that flat and inverted states have finite energy and are pushed back.
template <class T>
struct NeoHookean {
  static constexpr T kSmallestVolume = T(0.001);
  T mu, lambda;

  T energy(const Mat3<T>& F) const {
    const T g = log_volume(F.determinant()).value;
    return T(0.5) * mu * (F.squaredNorm() - 3) - mu * g + T(0.5) * lambda * g * g;
  }

  /// tau = mu F F^T + (lambda g - mu) g' J I with g = ln J.
  Mat3<T> stress(const Mat3<T>& F) const {
    const T J = F.determinant();
    const LogVolume g = log_volume(J);
    return mu * (F * F.transpose()) + (lambda * g.value - mu) * g.slope * J * Mat3<T>::Identity();
  }

  /// P = dPsi/dF = mu F + (lambda g - mu) g' cof F with g = ln J.
  Mat3<T> piola(const Mat3<T>& F) const {
    const Mat3<T> C = cofactor(F);
    const LogVolume g = log_volume(F.col(0).dot(C.col(0)));
    return mu * F + (lambda * g.value - mu) * g.slope * C;
  }
  LawGradient<T> piola_adjoint(const Mat3<T>& F, const Mat3<T>& adj_P) const {
    const Mat3<T> C = cofactor(F);
    const T J = F.col(0).dot(C.col(0)), along = adj_P.cwiseProduct(C).sum();
    const LogVolume g = log_volume(J);
    const T slope_of_slope = J < kSmallestVolume ? T(0) : -g.slope * g.slope;
    const T pressure = lambda * g.value - mu;
    LawGradient<T> out;
    out.F = mu * adj_P + (lambda * g.slope * g.slope + pressure * slope_of_slope) * along * C +
            pressure * g.slope * cofactor_derivative(F, adj_P);
    out.mu = adj_P.cwiseProduct(F).sum() - g.slope * along;
    out.lambda = g.value * g.slope * along;
    return out;
  }

  LawGradient<T> stress_adjoint(const Mat3<T>& F, const Mat3<T>& adj_tau) const {
    const Mat3<T> C = cofactor(F), A = T(0.5) * (adj_tau + adj_tau.transpose()), AF = A * F;
    const T J = F.col(0).dot(C.col(0)), trace = A.trace();
    const LogVolume g = log_volume(J);
    // g' J is 1 for the logarithm and J / J0 for its tangent.
    const T slope_of_gJ = J < kSmallestVolume ? g.slope : T(0);
    const T by_J = lambda * g.slope * (g.slope * J) + (lambda * g.value - mu) * slope_of_gJ;
    LawGradient<T> out;
    out.F = 2 * mu * AF + by_J * trace * C;
    out.mu = AF.cwiseProduct(F).sum() - g.slope * J * trace;
    out.lambda = g.value * g.slope * J * trace;
    return out;
  }

 private:
  struct LogVolume {
    T value, slope;
  };
  static LogVolume log_volume(T J) {
    if (J < kSmallestVolume) return {std::log(kSmallestVolume) + J / kSmallestVolume - 1, 1 / kSmallestVolume};
    return {std::log(J), 1 / J};
  }
};

}  // namespace pliant
