#pragma once

#include "physics/laws/hencky.h"

namespace pliant {

/// Foam: what |dev tau| exceeds sqrt(2/3) yield_stress by decays in the time plastic_viscosity / (2 mu), at constant
/// volume: d|dev e| / dt = -(|dev tau| - sqrt(2/3) yield_stress) / plastic_viscosity, one implicit step (Perzyna 1966;
/// the scheme of Yue et al. 2015 with exponent 1, in Hencky strain).
/// Valid for foams, pastes and creams that hold their shape under small loads and flow at a rate in proportion to what
/// exceeds the yield stress; without viscosity it is perfect plasticity.
struct Viscoplastic {
  double yield_stress, viscosity, dt;

  template <class S>
  bool operator()(Principal<S>& p) const {
    const HenckyStrain<S> strain(p.sigma);
    const S norm = strain.norm(), stress = S(2) * p.mu * norm, excess = stress - S(std::sqrt(2.0 / 3) * yield_stress);
    if (excess > S(0)) {
      const S step = S(2 * dt) * p.mu;
      p.sigma = strain.stretches(S(1) - excess * step / ((step + S(viscosity)) * stress));
      return true;
    }
    if (strain.lifted) p.sigma = strain.stretches(S(1));
    return strain.lifted;
  }
};

}  // namespace pliant
