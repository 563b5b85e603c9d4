#pragma once

#include <cmath>
#include <cstdint>
#include <type_traits>

#include "gaussians/base/portable.h"

namespace pliant {

/// Packs of 16 bytes, which every supported processor handles as one register (GCC and Clang vector extension).
using FloatPack = float __attribute__((vector_size(16)));
using DoublePack = double __attribute__((vector_size(16)));

template <class T>
using Pack = std::conditional_t<sizeof(T) == 4, FloatPack, DoublePack>;
template <class T>
constexpr int kLanes = 16 / static_cast<int>(sizeof(T));

/// Whether any lane of a comparison is true.
template <class Mask>
inline bool any(Mask mask) {
  using Words = long long __attribute__((vector_size(16)));
  const Words words = reinterpret_cast<Words>(mask);
  return (words[0] | words[1]) != 0;
}

/// Value kept within [low, high]; compiles to two instructions without a branch.
template <class T>
HOST_DEVICE inline T bounded(T value, T low, T high) {
  value = value < high ? value : high;
  return value > low ? value : low;
}

/// exp(x) for x <= 0 with a relative error below 4e-7: 2^n * 2^f, n whole, |f| <= 1/2, 2^f a polynomial (interpolated
/// at Chebyshev nodes).  x below -87 counts as -87.
inline FloatPack exp_nonpositive(FloatPack x) {
  using Ints = int32_t __attribute__((vector_size(16)));
  constexpr float kShift = 12582912.0f;  // 1.5 * 2^23: adding it rounds to whole numbers in the low bits
  const FloatPack low = FloatPack{} - 87.0f;
  x = x > low ? x : low;
  const FloatPack shifted = x * 1.44269504f + kShift;
  const FloatPack n = shifted - kShift;
  const FloatPack f = x * 1.44269504f - n;
  FloatPack p = f * 0.0013390863f + 0.009676032f;
  p = p * f + 0.05550357f;
  p = p * f + 0.24022107f;
  p = p * f + 0.69314719f;
  p = p * f + 1.0f;
  return reinterpret_cast<FloatPack>(reinterpret_cast<Ints>(p) + (reinterpret_cast<Ints>(shifted) << 23));
}

inline DoublePack exp_nonpositive(DoublePack x) { return DoublePack{std::exp(x[0]), std::exp(x[1])}; }
HOST_DEVICE inline float exp_nonpositive(float x) { return std::exp(x); }
HOST_DEVICE inline double exp_nonpositive(double x) { return std::exp(x); }

}  // namespace pliant
