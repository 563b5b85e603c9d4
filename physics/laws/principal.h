#pragma once

#include <array>

#include "gaussians/base/spectral.h"
#include "physics/laws/dual.h"
#include "physics/laws/law.h"

namespace pliant {

/// What an isotropic return map sees of a particle: F = U diag(sigma) V^T without U and V.  S is a scalar or a Dual.
template <class S>
struct Principal {
  std::array<S, 3> sigma;  ///< principal stretches, ascending; the first is negative when det F < 0
  S history, mu, lambda;
};

/// F <- U diag(sigma') V^T, history <- history' with map(Principal&), which returns whether it changed anything.
template <class Map, class T>
void principal_return_map(const Map& map, T mu, T lambda, Mat3<T>& F, T& history) {
  const Svd<T> s = svd(F);
  Principal<T> p{{s.sigma[0], s.sigma[1], s.sigma[2]}, history, mu, lambda};
  if (!map(p)) return;
  F = s.U * Vec3<T>(p.sigma[0], p.sigma[1], p.sigma[2]).asDiagonal() * s.V.transpose();
  history = p.history;
}

/// Its adjoint, for derivatives adj_F, adj_history of the results; gives F, history, mu and lambda.
template <class Map, class T>
LawGradient<T> principal_return_map_adjoint(const Map& map, T mu, T lambda, const Mat3<T>& trial_F, T trial_history,
                                            const Mat3<T>& adj_F, T adj_history) {
  using D = Dual<T, 6>;  // by sigma (0..2), history, mu, lambda
  const Svd<T> s = svd(trial_F);
  Principal<D> p{{D::input(s.sigma[0], 0), D::input(s.sigma[1], 1), D::input(s.sigma[2], 2)},
                 D::input(trial_history, 3),
                 D::input(mu, 4),
                 D::input(lambda, 5)};
  LawGradient<T> g;
  if (!map(p)) {
    g.F = adj_F;
    g.history = adj_history;
    return g;
  }
  Vec3<T> sigma;
  Mat3<T> slope;
  for (int i = 0; i < 3; ++i) {
    sigma[i] = p.sigma[i].value;
    for (int j = 0; j < 3; ++j) slope(i, j) = p.sigma[i].slope[j];
  }
  // By the last three inputs everything goes through sigma' and history' alone.
  const Vec3<T> adj_sigma = (s.U.transpose() * adj_F * s.V).diagonal();
  const auto by = [&](int k) {
    T sum = adj_history * p.history.slope[k];
    for (int i = 0; i < 3; ++i) sum += adj_sigma[i] * p.sigma[i].slope[k];
    return sum;
  };
  g.history = by(3);
  g.mu = by(4);
  g.lambda = by(5);
  const Vec3<T> through_history = adj_history * Vec3<T>(p.history.slope[0], p.history.slope[1], p.history.slope[2]);
  g.F = spectral_adjoint<T>(s, sigma, slope, adj_F) + s.U * through_history.asDiagonal() * s.V.transpose();
  return g;
}

}  // namespace pliant
