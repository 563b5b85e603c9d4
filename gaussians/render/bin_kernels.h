#pragma once

#include "gaussians/render/blend.h"
#include "gaussians/simd/pack.h"

// Which blocks of which tiles a splat can change.  Here the lanes of a pack are rows of pixels.

namespace pliant::PLIANT_ISA {

/// Columns of blocks [from, to) of the image that the ellipse alpha >= 1/255 meets in each row of a row of tiles.
template <class T>
struct RowSpans {
  static constexpr int kPacks = kTileSize / kLanes;
  Mask<T> from[kPacks], to[kPacks];
};

template <class T>
inline void find_spans(const Splat<T>& s, int top, int width, int height, RowSpans<T>& spans) {
  using V = Pack<T>;
  // Spans are widened by this much so that rounding cannot drop a pixel; the exact test on alpha decides.
  constexpr T kMargin = T(0.01), kReachMargin = T(1e-3), kLog2Of255 = T(7.994353436858858);
  const T reach = s.log2_opacity + kLog2Of255 + kReachMargin, inverse = 1 / s.precision_x;
  const V zero{}, first = zero - 4, last = zero + T(width), bottom = zero + (T(height) - s.v);
  V d;
  for (int lane = 0; lane < kLanes; ++lane) d[lane] = T(lane);
  d += T(top) + T(0.5) - s.v;
  for (int p = 0; p < RowSpans<T>::kPacks; ++p, d += T(kLanes)) {
    const V squared = (reach - s.precision_y * d * d) * inverse;
    const V half = square_root(higher(squared, zero)) + kMargin;
    const V centre = s.u + s.slope * d;
    const Mask<T> met = (squared > zero) & (d < bottom);
    // Pixel i has its centre at i + 0.5; conversion to whole numbers cuts towards zero.
    const V low = lower(higher(centre - half + T(0.5), zero), last) * T(0.25);
    const V high = lower(higher(centre + half - T(0.5), first), last - 1) * T(0.25) + 1;
    spans.from[p] = whole(low);
    spans.to[p] = whole(high) & met;
  }
}

/// Bits of TileEntry::blocks for the tile whose first column of blocks is `first`.
template <class T>
inline uint64_t blocks_within(const RowSpans<T>& spans, int first) {
  using M = Mask<T>;
  const M zero{}, four = zero + 4, one = zero + 1;
  M place;
  for (int lane = 0; lane < kLanes; ++lane) place[lane] = 4 * lane;
  uint64_t blocks = 0;
  for (int p = 0; p < RowSpans<T>::kPacks; ++p) {
    const M from = lower(higher(spans.from[p] - first, zero), four),
            to = lower(higher(spans.to[p] - first, zero), four);
    const M run = higher((one << to) - (one << from), zero);
    blocks |= static_cast<uint64_t>(or_lanes(run << place)) << (4 * kLanes * p);
  }
  return blocks;
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
      RowSpans<T> spans;
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
