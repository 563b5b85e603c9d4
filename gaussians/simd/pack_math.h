#pragma once

#include "gaussians/simd/pack.h"

// Elementary functions, vectors and 3x3 matrices of packs.

namespace pliant::PLIANT_ISA {

/// e^x with a relative error below 2e-7 in float; overflows to infinity, underflows to 0, and NaN stays NaN.
/// 2^n e^f, n whole, |f| <= ln(2) / 2, e^f by its series.
inline FloatPack exponential(FloatPack x) {
  constexpr float kShift = 12582912.0f, kLog2E = 1.44269504f;  // see exp2_nonpositive
  constexpr float kLn2High = 0.693359375f, kLn2Low = -2.12194440e-4f;
  // Comparisons with NaN take the second operand, which keeps it.
  x = higher(FloatPack{} - 104.0f, lower(FloatPack{} + 89.0f, x));
  const FloatPack shifted = fma(x, FloatPack{} + kLog2E, FloatPack{} + kShift), whole = shifted - kShift;
  const FloatPack f = fma(whole, FloatPack{} - kLn2Low, fma(whole, FloatPack{} - kLn2High, x));
  FloatPack p = FloatPack{} + 1.0f / 5040;
  p = fma(p, f, FloatPack{} + 1.0f / 720);
  p = fma(p, f, FloatPack{} + 1.0f / 120);
  p = fma(p, f, FloatPack{} + 1.0f / 24);
  p = fma(p, f, FloatPack{} + 1.0f / 6);
  p = fma(p, f, FloatPack{} + 0.5f);
  p = fma(p, f, FloatPack{} + 1.0f);
  p = fma(p, f, FloatPack{} + 1.0f);
  // In two factors, as 2^n alone may lie outside the range of normal numbers.
  const Mask<float> n = reinterpret_cast<Mask<float>>(shifted) - 0x4b400000, half = n >> 1;
  return p * reinterpret_cast<FloatPack>((half + 127) << 23) * reinterpret_cast<FloatPack>((n - half + 127) << 23);
}
inline DoublePack exponential(DoublePack x) {
  for (int i = 0; i < kLanes; ++i) x[i] = __builtin_exp(x[i]);
  return x;
}

/// log2(x) with a relative error below 2.5e-7 in float, for normal x > 0: x = 2^n m with m between sqrt(1/2) and
/// sqrt(2), log2(m) = 2 / ln(2) artanh((m - 1) / (m + 1)) by its series.
inline FloatPack logarithm2(FloatPack x) {
  constexpr float kScale = 2.88539008f, kScaleRest = 3.85192598e-08f;  // 2 / ln(2)
  // Unsigned, because other x may wrap around.
  typedef uint32_t Bits __attribute__((vector_size(sizeof(FloatPack))));
  const Bits bits = reinterpret_cast<Bits>(x);
  const Mask<float> n = reinterpret_cast<Mask<float>>(bits - 0x3f3504f3u) >> 23;
  const FloatPack m = reinterpret_cast<FloatPack>(bits - (reinterpret_cast<Bits>(n) << 23)),
                  s = (m - 1.0f) / (m + 1.0f), z = s * s;
  FloatPack p = FloatPack{} + kScale / 9;
  p = fma(p, z, FloatPack{} + kScale / 7);
  p = fma(p, z, FloatPack{} + kScale / 5);
  p = fma(p, z, FloatPack{} + kScale / 3);
  p = fma(p, z, FloatPack{} + kScaleRest);
  return fma(s, FloatPack{} + kScale, s * p) + __builtin_convertvector(n, FloatPack);
}
inline DoublePack logarithm2(DoublePack x) {
  for (int i = 0; i < kLanes; ++i) x[i] = __builtin_log2(x[i]);
  return x;
}

/// Lanes that are neither infinite nor NaN.
template <class V>
INLINE auto finite(V v) {
  return v - v == V{};
}
/// Bit i: whether the mask is set in lane i.
template <class M>
INLINE uint32_t lane_bits(M mask) {
  uint32_t bits = 0;
  for (int i = 0; i < kLanes; ++i) bits |= (mask[i] != 0 ? 1u : 0u) << i;
  return bits;
}
#if defined(__AVX2__)
INLINE uint32_t lane_bits(Mask<float> mask) {
  return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
}
#endif

template <class T>
struct Pack3 {
  Pack<T> x, y, z;
};
template <class T>
INLINE Pack3<T> everywhere(const T* v) {
  return {Pack<T>{} + v[0], Pack<T>{} + v[1], Pack<T>{} + v[2]};
}
template <class T>
INLINE Pack3<T> operator+(const Pack3<T>& a, const Pack3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
INLINE Pack3<T> operator-(const Pack3<T>& a, const Pack3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
INLINE Pack3<T> operator*(Pack<T> s, const Pack3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
INLINE Pack3<T> fma(Pack<T> s, const Pack3<T>& a, const Pack3<T>& b) {
  return {fma(s, a.x, b.x), fma(s, a.y, b.y), fma(s, a.z, b.z)};
}
/// Component by component.
template <class T>
INLINE Pack3<T> product(const Pack3<T>& a, const Pack3<T>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
template <class T>
INLINE Pack<T> dot(const Pack3<T>& a, const Pack3<T>& b) {
  return fma(a.z, b.z, fma(a.y, b.y, a.x * b.x));
}
template <class T>
INLINE Pack3<T> cross(const Pack3<T>& a, const Pack3<T>& b) {
  return {fma(a.y, b.z, -(a.z * b.y)), fma(a.z, b.x, -(a.x * b.z)), fma(a.x, b.y, -(a.y * b.x))};
}

template <class T>
struct PackMatrix {
  Pack3<T> row[3];
};
template <class T>
INLINE Pack3<T> operator*(const PackMatrix<T>& M, const Pack3<T>& v) {
  return {dot(M.row[0], v), dot(M.row[1], v), dot(M.row[2], v)};
}
/// M^T v
template <class T>
INLINE Pack3<T> transposed(const PackMatrix<T>& M, const Pack3<T>& v) {
  return fma(v.z, M.row[2], fma(v.y, M.row[1], v.x * M.row[0]));
}

}  // namespace pliant::PLIANT_ISA
