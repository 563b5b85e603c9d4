#pragma once

#include <type_traits>

#include "physics/laws/hencky.h"

namespace pliant {

/// Sand: |dev tau| <= -alpha tr(tau) in Kirchhoff stress, alpha = sqrt(2/3) 2 sin(phi) / (3 - sin(phi)), flow at
/// constant volume; in tension the grains part freely (F becomes a rotation), and the volume that they gain (the
/// history, as a logarithm) has to be pressed out again before they bear load (Klar et al. 2016, section 7 and the
/// correction of Tampubolon et al. 2017).
/// Valid for dry grains without cohesion; the slope at which a deep bed slips is tan(theta) = 2 sqrt(3) sin(phi) /
/// (3 - sin(phi)), steeper than phi.
struct DruckerPrager {
  double alpha;

  static double alpha_of(double friction_angle_degrees) {
    const double s = std::sin(friction_angle_degrees * (M_PI / 180));
    return std::sqrt(2.0 / 3) * 2 * s / (3 - s);
  }

  template <class S>
  bool operator()(Principal<S>& p) const {
    HenckyStrain<S> strain(p.sigma);
    // At history 0 the strain is what it was, but not its derivative.
    const bool corrected = !std::is_floating_point_v<S> || p.history > S(0) || p.history < S(0);
    strain.trace += p.history;
    if (!(strain.trace < S(0))) {
      p.sigma = {S(1), S(1), S(1)};
      p.history = strain.trace;
      return true;
    }
    p.history = S(0);
    const S norm = strain.norm();
    const S excess = norm + (S(3) * p.lambda + S(2) * p.mu) / (S(2) * p.mu) * strain.trace * S(alpha);
    if (excess > S(0)) {
      p.sigma = strain.stretches(excess < norm ? (norm - excess) / norm : S(0));
      return true;
    }
    if (!corrected && !strain.lifted) return false;
    p.sigma = strain.stretches(S(1));
    return true;
  }
};

}  // namespace pliant
