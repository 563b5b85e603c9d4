#pragma once

#include "physics/laws/hencky.h"

namespace pliant {

/// Snow: principal stretches stay in [1 - critical_compression, 1 + critical_stretch]; what exceeds them goes into the
/// plastic volume J_p, whose logarithm is the history; the Lame parameters of the fixed corotated energy are multiplied
/// by exp(xi (1 - J_p)) (Stomakhin et al. 2013, section 5).
/// Valid for packed snow that crumbles in tension and hardens when compacted; hardening ends at exp(3) = 20 times the
/// stiffness of fresh snow, so that the time step stays bounded, and J_p is remembered between 1/20 and 20.
struct SnowClamp {
  double critical_compression, critical_stretch;

  template <class S>
  bool operator()(Principal<S>& p) const {
    using std::log;
    const S low = S(1 - critical_compression), high = S(1 + critical_stretch);
    bool changed = false;
    for (S& sigma : p.sigma) {
      if (!(sigma < low) && !(sigma > high)) continue;
      const S& bound = sigma < low ? low : high;
      p.history += log((sigma < S(kSmallestStretch) ? S(kSmallestStretch) : sigma) / bound);
      sigma = bound;
      changed = true;
    }
    constexpr double kMost = 3;  // of |ln J_p|
    if (p.history > S(kMost)) {
      p.history = S(kMost);
      changed = true;
    }
    if (p.history < S(-kMost)) {
      p.history = S(-kMost);
      changed = true;
    }
    return changed;
  }
};

/// Factor of the Lame parameters and its derivative by the history ln J_p.
template <class T>
struct SnowHardening {
  T factor, slope;

  SnowHardening(double xi, T log_plastic_volume) {
    const T volume = std::exp(log_plastic_volume), exponent = T(xi) * (1 - volume);
    const bool bounded = exponent > T(kLargestExponent);
    factor = std::exp(bounded ? T(kLargestExponent) : exponent);
    slope = bounded ? T(0) : -T(xi) * volume * factor;
  }
  static constexpr double kLargestExponent = 3;
  static double largest(double xi) { return std::exp(std::min(xi, kLargestExponent)); }
};

}  // namespace pliant
