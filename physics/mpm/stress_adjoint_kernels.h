#pragma once

#include "gaussians/base/polar.h"

namespace pliant::PLIANT_ISA {

/// Fixed corotated tau and the way back from it.
template <class T>
struct StressPoint {
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  Mat3<T> F;
  Polar<T> p;
  T mu, lambda, J;

  StressPoint(const T* f, T mu, T lambda)
      : F(Eigen::Map<const RowMajor>(f)), p(polar(F)), mu(mu), lambda(lambda), J(F.determinant()) {}

  void kirchhoff(T* tau) const {
    const Mat3<T> t = 2 * mu * (F - p.R) * F.transpose() + lambda * (J - 1) * J * Mat3<T>::Identity();
    tau[0] = t(0, 0), tau[1] = t(1, 1), tau[2] = t(2, 2);
    tau[3] = T(0.5) * (t(1, 2) + t(2, 1)), tau[4] = T(0.5) * (t(0, 2) + t(2, 0)), tau[5] = T(0.5) * (t(0, 1) + t(1, 0));
  }

  void reverse(const T* s, T* by_F, T& by_mu, T& by_lambda) const {
    Mat3<T> S;
    S << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
    const Mat3<T> SF = S * F;
    const T trace = S.trace();
    const Mat3<T> D = 2 * mu * (2 * SF - S * p.R - polar_rotation_derivative(p, SF)) +
                      lambda * trace * (2 * J - 1) * cofactor(F);
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 3; ++c) by_F[3 * a + c] += D(a, c);
    by_mu += 2 * S.cwiseProduct((F - p.R) * F.transpose()).sum();
    by_lambda += trace * (J - 1) * J;
  }
};

}  // namespace pliant::PLIANT_ISA
