#pragma once

#include "gaussians/simd/pack.h"

// Rows of arrays [N, width] between memory and lanes, one row per lane.

namespace pliant::PLIANT_ISA {

/// Which rows lie in the lanes; lanes from `count` on repeat the last of them, and are never written.
struct Rows {
  uint32_t of[kLanes];
  int count;

  INLINE bool used(int lane) const { return lane < count; }
};

/// Rows row(first), row(first + 1), ... below row(end).
template <class Row>
INLINE Rows rows_from(size_t first, size_t end, Row row) {
  Rows rows;
  rows.count = end - first < kLanes ? static_cast<int>(end - first) : kLanes;
  for (int lane = 0; lane < kLanes; ++lane) rows.of[lane] = row(first + (rows.used(lane) ? lane : rows.count - 1));
  return rows;
}

/// Lanes whose row is not a repeated one.
template <class T>
INLINE Mask<T> used_lanes(const Rows& rows) {
  Mask<T> lane;
  for (int i = 0; i < kLanes; ++i) lane[i] = i;
  return lane < Mask<T>{} + rows.count;
}

/// out[k] = column k of the rows.
template <class T>
INLINE void load_rows(const T* from, const Rows& rows, int width, Pack<T>* out) {
  for (int k = 0; k < width; ++k) {
    Pack<T> column{};
    for (int lane = 0; lane < kLanes; ++lane) column[lane] = from[static_cast<size_t>(rows.of[lane]) * width + k];
    out[k] = column;
  }
}

/// Adds columns to the rows.
template <class T>
INLINE void add_rows(const Pack<T>* columns, const Rows& rows, int width, T* to) {
  for (int lane = 0; lane < rows.count; ++lane) {
    T* row = to + static_cast<size_t>(rows.of[lane]) * width;
    for (int k = 0; k < width; ++k) row[k] += columns[k][lane];
  }
}

#if defined(__AVX2__)
/// Transposes the 4x4 blocks of the lower and of the upper lanes.
INLINE void transpose_quarters(__m256 (&v)[4]) {
  const __m256 a = _mm256_unpacklo_ps(v[0], v[1]), b = _mm256_unpackhi_ps(v[0], v[1]);
  const __m256 c = _mm256_unpacklo_ps(v[2], v[3]), d = _mm256_unpackhi_ps(v[2], v[3]);
  v[0] = _mm256_shuffle_ps(a, c, 0x44);
  v[1] = _mm256_shuffle_ps(a, c, 0xee);
  v[2] = _mm256_shuffle_ps(b, d, 0x44);
  v[3] = _mm256_shuffle_ps(b, d, 0xee);
}

// Four columns at a time; nothing behind the end of a row is read or written.
INLINE void load_rows(const float* from, const Rows& rows, int width, FloatPack* out) {
  for (int k = 0; k < width; k += 4) {
    const int columns = width - k < 4 ? width - k : 4;
    const __m128i wanted = _mm_cmpgt_epi32(_mm_set1_epi32(columns), _mm_setr_epi32(0, 1, 2, 3));
    const auto load = [&](int lane) {
      const float* row = from + static_cast<size_t>(rows.of[lane]) * width + k;
      return columns == 4 ? _mm_loadu_ps(row) : _mm_maskload_ps(row, wanted);
    };
    __m256 v[4];
    for (int i = 0; i < 4; ++i) v[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(load(i)), load(i + 4), 1);
    transpose_quarters(v);
    for (int i = 0; i < columns; ++i) out[k + i] = v[i];
  }
}

INLINE void add_rows(const FloatPack* columns, const Rows& rows, int width, float* to) {
  for (int k = 0; k < width; k += 4) {
    const int here = width - k < 4 ? width - k : 4;
    __m256 v[4];
    for (int i = 0; i < 4; ++i) v[i] = columns[k + (i < here ? i : 0)];
    transpose_quarters(v);
    for (int lane = 0; lane < rows.count; ++lane) {
      float* row = to + static_cast<size_t>(rows.of[lane]) * width + k;
      const __m128 add = lane < 4 ? _mm256_castps256_ps128(v[lane]) : _mm256_extractf128_ps(v[lane - 4], 1);
      if (here == 4) {
        _mm_storeu_ps(row, _mm_add_ps(_mm_loadu_ps(row), add));
      } else {
        for (int i = 0; i < here; ++i) row[i] += add[i];
      }
    }
  }
}
#endif

}  // namespace pliant::PLIANT_ISA
