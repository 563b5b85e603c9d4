#pragma once

#include <cmath>
#include <cstdint>

namespace pliant {

/// Counter-based random numbers: the stream is a pure function of (seed, element, step), so results do not depend on
/// threads or on the order of calls.  Mixing: SplitMix64 finaliser (Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(uint64_t seed, uint64_t element = 0, uint64_t step = 0)
      : state_(mix(mix(mix(seed + 0x9e3779b97f4a7c15ull) ^ element) + 0x9e3779b97f4a7c15ull * (step + 1))) {}

  uint64_t bits() { return mix(state_ += 0x9e3779b97f4a7c15ull); }

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform integer in [0, n).
  uint64_t below(uint64_t n) { return static_cast<uint64_t>(uniform() * static_cast<double>(n)); }

  /// Standard normal (Box and Muller 1958).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

 private:
  static uint64_t mix(uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  uint64_t state_;
};

}  // namespace pliant
