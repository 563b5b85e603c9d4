#pragma once

#include "physics/laws/hencky.h"

namespace pliant {

/// Metal and plasticine: |dev tau| <= sqrt(2/3) Y, Y = max(0, yield_stress + hardening eps_p), where yield_stress is
/// the one of a uniaxial test and eps_p (the history) grows by sqrt(2/3) of the plastic strain's norm; radial return in
/// Hencky strain, exact for linear hardening (Wilkins 1964; Simo 1992), at constant volume.
/// Valid for metals, clay and wax, whose flow does not depend on pressure or rate.  A negative hardening softens with
/// plastic strain until Y = 0; from there on the body flows without resisting shear and keeps its volume elastically.
struct VonMises {
  double yield_stress, hardening;

  template <class S>
  bool operator()(Principal<S>& p) const {
    const HenckyStrain<S> strain(p.sigma);
    const S root = S(std::sqrt(2.0 / 3)), norm = strain.norm(), stress = S(2) * p.mu * norm;
    S yield = S(yield_stress) + S(hardening) * p.history;
    if (yield < S(0)) yield = S(0);
    const S excess = stress - root * yield;
    if (!(excess > S(0))) {
      if (strain.lifted) p.sigma = strain.stretches(S(1));
      return strain.lifted;
    }
    // stress - 2 mu flow = root Y(history + root flow); where Y would pass zero, or falls faster than the elastic
    // stress (so that there is no other answer), all of the deviator goes.
    const S stiffness = S(2) * p.mu + S(2.0 / 3 * hardening);
    S flow = norm;
    if (stiffness > S(0)) {
      const S hardened = excess / stiffness;
      if (hardened < norm) flow = hardened;
    }
    p.sigma = strain.stretches((norm - flow) / norm);
    p.history += root * flow;
    return true;
  }
};

}  // namespace pliant
