#pragma once

#include "gaussians/render/blend.h"
#include "gaussians/simd/pack.h"

// Which pixels a splat meets, and what it does to them.  A tile is 4 columns of blocks, 4 px wide and kLanes / 4 px
// high; the pixels of a block are the lanes of one pack.

namespace pliant::PLIANT_ISA {

constexpr int kBlockRows = kLanes / 4, kBlocks = kTilePixels / kLanes;

/// The bits of all rows of a block gathered at its first row.
inline uint64_t blocks_of(uint64_t rows) {
  for (int r = 1; r < kBlockRows; r *= 2) rows |= rows >> (4 * r);
  constexpr uint64_t kFirstRows = kBlockRows == 1   ? ~0ull
                                  : kBlockRows == 2 ? 0x0f0f0f0f0f0f0f0full
                                                    : 0x000f000f000f000full;
  return rows & kFirstRows;
}
inline int block_of(int bit) { return (bit >> 2) / kBlockRows * 4 + (bit & 3); }

/// One attribute of a tile between pixels, row by row, and lanes.
template <class T>
inline void lanes_from_pixels(const T* pixels, int block, Pack<T>& pack) {
  const T* from = pixels + block / 4 * kBlockRows * kTileSize + block % 4 * 4;
  for (int r = 0; r < kBlockRows; ++r)
    __builtin_memcpy(reinterpret_cast<char*>(&pack) + r * 4 * sizeof(T), from + r * kTileSize, 4 * sizeof(T));
}
template <class T>
inline void pixels_from_lanes(const Pack<T>& pack, int block, T* pixels) {
  T* to = pixels + block / 4 * kBlockRows * kTileSize + block % 4 * 4;
  for (int r = 0; r < kBlockRows; ++r)
    __builtin_memcpy(to + r * kTileSize, reinterpret_cast<const char*>(&pack) + r * 4 * sizeof(T), 4 * sizeof(T));
}

/// Transmittance of the pixels of a tile; negative once a pixel takes nothing more.
template <class T>
struct TileState {
  Pack<T> transmittance[kBlocks];
  Pack<T> centre_x[4], centre_y[kTileSize / kBlockRows];  ///< of the pixels, from the tile's corner

  explicit TileState(const TileInput<T>& in, bool cut_offs) {
    for (int lane = 0; lane < kLanes; ++lane) {
      for (int i = 0; i < 4; ++i) centre_x[i][lane] = T(4 * i + lane % 4) + T(0.5);
      for (int i = 0; i < kTileSize / kBlockRows; ++i) centre_y[i][lane] = T(kBlockRows * i + lane / 4) + T(0.5);
    }
    const Pack<T> open = all<Pack<T>>(T(1)), outside = all<Pack<T>>(cut_offs ? T(-1) : T(0));
    for (int block = 0; block < kBlocks; ++block) {
      const Mask<T> inside = (centre_x[block % 4] < T(in.columns)) & (centre_y[block / 4] < T(in.rows));
      transmittance[block] = inside ? open : outside;
    }
  }
};

/// What one splat does to the pixels of one block.
template <class T>
struct Contribution {
  Pack<T> e, d;           ///< offsets from the mean, see Splat
  Pack<T> alpha;          ///< 0 where it is below the smallest alpha
  Pack<T> transmittance;  ///< in front of the splat
  Pack<T> weight;         ///< alpha * transmittance; 0 where the pixel takes nothing more
  Mask<T> smooth;         ///< whether alpha still follows the splat: it counts, and is not held at the largest alpha
};

/// Alpha and weight of a splat in one block, and the transmittance behind it.
template <class T, bool kCutOffs>
INLINE Contribution<T> contribute(const Splat<T>& s, Pack<T> dx, Pack<T> d, Pack<T>& transmittance) {
  using V = Pack<T>;
  Contribution<T> c;
  c.d = d;
  c.e = fma(all<V>(-s.slope), d, dx);
  const V across = s.precision_y * d, along = s.precision_x * c.e;
  const V exponent = fma(-along, c.e, fma(-across, d, all<V>(s.log2_opacity)));
  c.transmittance = transmittance;
  if constexpr (kCutOffs) {
    const V full = exp2_nonpositive(exponent), most = all<V>(T(splat::kMaxAlpha));
    c.alpha = lower(full, most);
    const Mask<T> counts = c.alpha >= all<V>(T(splat::kMinAlpha));
    c.alpha = where(counts, c.alpha);
    const V after = fma(-c.alpha, transmittance, transmittance);
    const Mask<T> takes = after >= all<V>(T(splat::kMinTransmittance));
    c.weight = where(takes, c.alpha * transmittance);
    c.smooth = counts & takes & (full < most);
    // A pixel that takes nothing more is marked by the sign of its transmittance.
    const V closed = transmittance < -transmittance ? transmittance : -transmittance;
    transmittance = takes ? after : closed;
  } else {
    c.alpha = exp2_nonpositive(exponent);
    c.weight = c.alpha * transmittance;
    c.smooth = V{} == V{};
    transmittance = transmittance - c.weight;
  }
  return c;
}

/// Front-to-back traversal of one tile, the one place where blend weights are made.  For each entry that meets a pixel
/// which still takes something: local = visitor.begin(splat), visitor.add(local, block, contribution) for its blocks,
/// visitor.end(local, entry); for the others visitor.skip(entry).  Entries are numbered within the tile.
template <class T, bool kCutOffs, class Visitor>
INLINE void traverse(const TileInput<T>& in, TileState<T>& state, Visitor& visitor) {
  constexpr size_t kAhead = 8;
  uint64_t open = blocks_of(~0ull);
  size_t i = 0;
  for (; i < in.count && open; ++i) {
    const TileEntry entry = in.entries[i];
    if (i + kAhead < in.count) __builtin_prefetch(&in.splats[in.entries[i + kAhead].splat]);
    uint64_t blocks = blocks_of(entry.blocks) & open;
    if (!blocks) {
      visitor.skip(i);
      continue;
    }
    const Splat<T> s = in.splats[entry.splat];
    const T u = s.u - T(in.left), v = s.v - T(in.top);
    auto local = visitor.begin(s);
    do {
      const int bit = __builtin_ctzll(blocks), block = block_of(bit);
      blocks &= blocks - 1;
      Pack<T>& transmittance = state.transmittance[block];
      visitor.add(local, block,
                  contribute<T, kCutOffs>(s, state.centre_x[bit & 3] - u, state.centre_y[(bit >> 2) / kBlockRows] - v,
                                          transmittance));
      if (kCutOffs && all_negative(transmittance)) open &= ~(1ull << bit);
    } while (blocks);
    visitor.end(local, i);
  }
  for (; i < in.count; ++i) visitor.skip(i);
}

}  // namespace pliant::PLIANT_ISA
