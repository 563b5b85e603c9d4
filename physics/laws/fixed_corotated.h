#pragma once

#include "gaussians/base/polar.h"
#include "physics/laws/law.h"

namespace pliant {

/// Psi = mu |F - R|^2 + lambda/2 (J - 1)^2 with F = R S, J = det F (Stomakhin et al. 2012, eq. 11).
/// Valid for any rotation and moderate strain (Hooke's law at first order); it resists inversion with finite forces, so
/// compression to nothing costs only finite energy.
template <class T>
struct FixedCorotated {
  T mu, lambda;

  T energy(const Mat3<T>& F) const {
    const T volume = F.determinant() - 1;
    return mu * (F - polar_rotation(F)).squaredNorm() + T(0.5) * lambda * volume * volume;
  }

  /// tau = 2 mu (F - R) F^T + lambda (J - 1) J I.
  Mat3<T> stress(const Mat3<T>& F) const {
    const T J = F.determinant();
    const Mat3<T> shear = mu * ((F - polar_rotation(F)) * F.transpose());
    return shear + shear.transpose() + lambda * (J - 1) * J * Mat3<T>::Identity();
  }

  /// P = dPsi/dF = 2 mu (F - R) + lambda (J - 1) cof F.
  Mat3<T> piola(const Mat3<T>& F) const {
    const Mat3<T> C = cofactor(F);
    const T J = F.col(0).dot(C.col(0));
    return 2 * mu * (F - polar_rotation(F)) + lambda * (J - 1) * C;
  }
  LawGradient<T> piola_adjoint(const Mat3<T>& F, const Mat3<T>& adj_P) const {
    const Polar<T> p = polar(F);
    const Mat3<T> C = cofactor(F), D = F - p.R;
    const T J = F.col(0).dot(C.col(0)), along = adj_P.cwiseProduct(C).sum();
    LawGradient<T> g;
    g.F = 2 * mu * (adj_P - polar_rotation_derivative(p, adj_P)) +
          lambda * (along * C + (J - 1) * cofactor_derivative(F, adj_P));
    g.mu = 2 * adj_P.cwiseProduct(D).sum();
    g.lambda = (J - 1) * along;
    return g;
  }

  /// dR is the only part that is not plain algebra, and its own adjoint.
  LawGradient<T> stress_adjoint(const Mat3<T>& F, const Mat3<T>& adj_tau) const {
    const Polar<T> p = polar(F);
    const Mat3<T> C = cofactor(F), D = F - p.R, A = T(0.5) * (adj_tau + adj_tau.transpose()), AF = A * F;
    const T J = F.col(0).dot(C.col(0)), trace = A.trace();
    LawGradient<T> g;
    g.F = 2 * mu * (AF + A * D - polar_rotation_derivative(p, AF)) + lambda * (2 * J - 1) * trace * C;
    g.mu = 2 * AF.cwiseProduct(D).sum();
    g.lambda = (J - 1) * J * trace;
    return g;
  }
};

}  // namespace pliant
