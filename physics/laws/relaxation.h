#pragma once

#include "physics/laws/hencky.h"

namespace pliant {

/// Relaxing branch of viscoelasticity: its Hencky strain decays in the time viscosity / (2 mu) in shear and
/// viscosity / (2 K) in volume, K = lambda + 2 mu / 3, one implicit step:
///   e' = A (e - B tr(e) 1), A = 1 / (1 + dt a), B = dt b / (1 + dt (a + 3 b)),
///   a = 2 mu / viscosity, b = 2 (2 mu + 3 lambda) / (9 viscosity) - a / 3 (Reese and
/// Govindjee 1998; Physics3D 2024).  mu and lambda are the branch's own.
/// Valid beside an elastic branch, for bodies that answer a fast load stiffly and a slow one softly.
struct Relaxation {
  double viscosity, dt;

  template <class S>
  bool operator()(Principal<S>& p) const {
    HenckyStrain<S> strain(p.sigma);
    const S rate(2 * dt / viscosity), bulk = p.lambda + p.mu * S(2.0 / 3);
    strain.trace = strain.trace / (S(1) + rate * bulk);
    p.sigma = strain.stretches(S(1) / (S(1) + rate * p.mu));
    return true;
  }
};

}  // namespace pliant
