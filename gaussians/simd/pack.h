#pragma once

// For the files that are compiled once per instruction set.  Each defines PLIANT_ISA, the namespace of its code: the
// same template compiled for two instruction sets under one name would be one symbol, and the linker might keep the
// wrong one.

#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

/// Inlined in any case: the accumulators of a loop then stay in registers.
#define INLINE __attribute__((always_inline)) inline

namespace pliant::PLIANT_ISA {

/// Pixels that are computed on together, 4 wide; one register of floats (GCC and Clang vector extension).
#if defined(__AVX2__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif

template <class T>
struct PackOf;
template <>
struct PackOf<float> {
  typedef float Type __attribute__((vector_size(4 * kLanes)));
  typedef int32_t Mask __attribute__((vector_size(4 * kLanes)));
};
template <>
struct PackOf<double> {
  typedef double Type __attribute__((vector_size(8 * kLanes)));
  typedef int64_t Mask __attribute__((vector_size(8 * kLanes)));
};
template <class T>
using Pack = typename PackOf<T>::Type;
template <class T>
using Mask = typename PackOf<T>::Mask;

using FloatPack = Pack<float>;
using DoublePack = Pack<double>;

/// x in every lane.  (Subtracting 0 changes no number, -0 included, so that only the copying remains.)
template <class V, class T>
inline V all(T x) {
  return x - V{};
}
/// a b + c; rounded once where the instruction exists.
template <class V>
inline V fma(V a, V b, V c) {
  return a * b + c;
}
template <class V>
inline V lower(V a, V b) {
  return a < b ? a : b;
}
template <class V>
inline V higher(V a, V b) {
  return a > b ? a : b;
}
/// `value` where the mask is set, else 0.
template <class V, class M>
inline V where(M mask, V value) {
  return reinterpret_cast<V>(reinterpret_cast<M>(value) & mask);
}
/// Whether every lane is negative; -0 counts as negative.
template <class V>
inline bool all_negative(V v) {
  bool all = true;
  for (int i = 0; i < kLanes; ++i) all &= __builtin_signbit(v[i]) != 0;
  return all;
}

inline float square_root(float x) { return __builtin_sqrtf(x); }
inline double square_root(double x) { return __builtin_sqrt(x); }
template <class V>
inline V square_root(V v) {
  for (int i = 0; i < kLanes; ++i) v[i] = square_root(v[i]);
  return v;
}
/// Whole numbers, cut towards zero.
inline Mask<float> whole(Pack<float> v) { return __builtin_convertvector(v, Mask<float>); }
inline Mask<double> whole(Pack<double> v) { return __builtin_convertvector(v, Mask<double>); }
/// Lanes of whole numbers joined by "or"; 32 bits.
template <class M>
inline uint32_t or_lanes(M m) {
  uint32_t all = 0;
  for (int i = 0; i < kLanes; ++i) all |= static_cast<uint32_t>(m[i]);
  return all;
}

/// out[i] = sum of the lanes of v[i], added in a fixed order.
template <class T>
inline void sum_lanes(const Pack<T>* v, int count, T* out) {
  for (int i = 0; i < count; ++i) {
    T sum[kLanes];
    for (int k = 0; k < kLanes; ++k) sum[k] = v[i][k];
    for (int half = kLanes / 2; half > 0; half /= 2)
      for (int k = 0; k < half; ++k) sum[k] += sum[k + half];
    out[i] = sum[0];
  }
}

#if defined(__AVX2__)
inline FloatPack fma(FloatPack a, FloatPack b, FloatPack c) { return _mm256_fmadd_ps(a, b, c); }
inline FloatPack lower(FloatPack a, FloatPack b) { return _mm256_min_ps(a, b); }
inline FloatPack higher(FloatPack a, FloatPack b) { return _mm256_max_ps(a, b); }
inline Mask<float> lower(Mask<float> a, Mask<float> b) {
  return reinterpret_cast<Mask<float>>(_mm256_min_epi32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
}
inline Mask<float> higher(Mask<float> a, Mask<float> b) {
  return reinterpret_cast<Mask<float>>(_mm256_max_epi32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
}
inline FloatPack square_root(FloatPack v) { return _mm256_sqrt_ps(v); }
inline uint32_t or_lanes(Mask<float> m) {
  const __m256i v = reinterpret_cast<__m256i>(m);
  const __m128i half = _mm_or_si128(_mm256_castsi256_si128(v), _mm256_extracti128_si256(v, 1));
  const __m128i quarter = _mm_or_si128(half, _mm_unpackhi_epi64(half, half));
  return static_cast<uint32_t>(_mm_cvtsi128_si32(quarter) | _mm_extract_epi32(quarter, 1));
}
inline bool all_negative(FloatPack v) { return _mm256_movemask_ps(v) == 0xff; }
inline void sum_lanes(const FloatPack* v, int count, float* out) {
  for (; count > 0; count -= 8, v += 8, out += 8) {
    // A short last group repeats its first pack; its spare results are not written.
    const auto at = [&](int i) { return static_cast<__m256>(v[i < count ? i : 0]); };
    const __m256 low = _mm256_hadd_ps(_mm256_hadd_ps(at(0), at(1)), _mm256_hadd_ps(at(2), at(3)));
    const __m256 high = _mm256_hadd_ps(_mm256_hadd_ps(at(4), at(5)), _mm256_hadd_ps(at(6), at(7)));
    const __m256 sum = _mm256_add_ps(_mm256_permute2f128_ps(low, high, 0x20), _mm256_permute2f128_ps(low, high, 0x31));
    if (count >= 8) {
      _mm256_storeu_ps(out, sum);
    } else {
      for (int i = 0; i < count; ++i) out[i] = reinterpret_cast<const FloatPack&>(sum)[i];
    }
  }
}
#endif

/// 2^x for x <= 0 with a relative error below 4e-7 in float: 2^n 2^f, n whole, |f| <= 1/2, 2^f a polynomial
/// (interpolated at Chebyshev nodes).  x below -126 counts as -126.
inline FloatPack exp2_nonpositive(FloatPack x) {
  constexpr float kShift = 12582912.0f;  // 1.5 * 2^23: adding it rounds to whole numbers in the low bits
  x = higher(x, all<FloatPack>(-126.0f));
  const FloatPack shifted = x + kShift;
  const FloatPack f = x - (shifted - kShift);
  FloatPack p = fma(f, all<FloatPack>(0.0013390863f), all<FloatPack>(0.009676032f));
  p = fma(p, f, all<FloatPack>(0.05550357f));
  p = fma(p, f, all<FloatPack>(0.24022107f));
  p = fma(p, f, all<FloatPack>(0.69314719f));
  p = fma(p, f, all<FloatPack>(1.0f));
  return reinterpret_cast<FloatPack>(reinterpret_cast<Mask<float>>(p) + (reinterpret_cast<Mask<float>>(shifted) << 23));
}
inline DoublePack exp2_nonpositive(DoublePack x) {
  for (int i = 0; i < kLanes; ++i) x[i] = __builtin_exp2(x[i]);
  return x;
}

}  // namespace pliant::PLIANT_ISA
