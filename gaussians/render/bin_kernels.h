#pragma once

#include "gaussians/render/blend.h"
#include "gaussians/render/pack.h"

// Which blocks of which tiles a splat can change.  The loops over the rows of a tile are written for vectorisation.

namespace pliant::PLIANT_ISA {

inline float square_root(float x) { return __builtin_sqrtf(x); }
inline double square_root(double x) { return __builtin_sqrt(x); }

template <class T>
inline T clamped(T value, T low, T high) {
  value = value < high ? value : high;
  return value > low ? value : low;
}

/// Columns of blocks [from, to) of the image that the ellipse alpha >= 1/255 meets in each row of a row of tiles.
struct RowSpans {
  int32_t from[kTileSize], to[kTileSize];
};

template <class T>
inline void find_spans(const Splat<T>& s, int top, int width, int height, RowSpans& spans) {
  // Spans are widened by this much so that rounding cannot drop a pixel; the exact test on alpha decides.
  constexpr T kMargin = T(0.01), kReachMargin = T(1e-3), kLog2Of255 = T(7.994353436858858);
  const T reach = s.log2_opacity + kLog2Of255 + kReachMargin, inverse = 1 / s.precision_x, most = T(width);
  const T first_y = T(top) + T(0.5) - s.v, bottom = T(height) - s.v;
  for (int r = 0; r < kTileSize; ++r) {
    const T d = first_y + T(r);
    const T squared = (reach - s.precision_y * d * d) * inverse;
    const T half = square_root(squared > 0 ? squared : 0) + kMargin;
    const T centre = s.u + s.slope * d;
    const bool met = squared > 0 && d < bottom;
    // Pixel i has its centre at i + 0.5; conversion to whole numbers cuts towards zero.
    const T low = clamped(centre - half + T(0.5), T(0), most) * T(0.25);
    const T high = clamped(centre + half - T(0.5), T(-4), most - 1) * T(0.25) + 1;
    spans.from[r] = static_cast<int32_t>(low);
    spans.to[r] = met ? static_cast<int32_t>(high) : 0;
  }
}

/// Bits of TileEntry::blocks for the tile whose first column of blocks is `first`.
inline uint64_t blocks_within(const RowSpans& spans, int32_t first) {
  uint32_t half[2] = {0, 0};
  for (int h = 0; h < 2; ++h) {
    uint32_t bits[8];
    for (int r = 0; r < 8; ++r) {
      const int32_t from = clamped(spans.from[8 * h + r] - first, 0, 4), to = clamped(spans.to[8 * h + r] - first, 0, 4);
      const int32_t run = (1 << to) - (1 << from);
      bits[r] = static_cast<uint32_t>(run > 0 ? run : 0) << (4 * r);
    }
    for (int r = 0; r < 8; ++r) half[h] |= bits[r];
  }
  return half[0] | static_cast<uint64_t>(half[1]) << 32;
}

template <class T, bool kCutOffs>
size_t bin(const BinInput<T>& in, TilePair* pairs, uint32_t* count_of_tile, uint32_t* count_of_splat) {
  TilePair* next = pairs;
  for (size_t i = in.begin; i < in.end; ++i) {
    if (i + 8 < in.end) __builtin_prefetch(&in.splats[in.order[i + 8]]);
    const uint32_t position = in.order[i];
    const Splat<T>& s = in.splats[position];
    const TilePair* first_pair = next;
    const int low = in.first_tile / in.tiles_x, high = (in.last_tile - 1) / in.tiles_x;
    for (int row = s.first_row < low ? low : s.first_row; row <= (s.last_row < high ? s.last_row : high); ++row) {
      RowSpans spans;
      if (kCutOffs) find_spans(s, row * kTileSize, in.width, in.height, spans);
      for (int column = s.first_column; column <= s.last_column; ++column) {
        const int tile = row * in.tiles_x + column;
        if (tile < in.first_tile || tile >= in.last_tile) continue;
        const uint64_t blocks = kCutOffs ? blocks_within(spans, 4 * column) : ~0ull;
        // Written in any case and kept if it counts: the branch would be hard to predict.
        *next = {blocks, position, static_cast<uint32_t>(tile - in.first_tile)};
        count_of_tile[tile - in.first_tile] += blocks != 0;
        next += blocks != 0;
      }
    }
    count_of_splat[position] = static_cast<uint32_t>(next - first_pair);
  }
  return static_cast<size_t>(next - pairs);
}

}  // namespace pliant::PLIANT_ISA
