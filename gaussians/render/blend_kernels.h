#pragma once

#include "gaussians/render/blend.h"
#include "gaussians/render/pack.h"

// Blending of one tile, forward and reverse.  A tile is 4 columns of blocks, 4 px wide and kLanes / 4 px high; the
// pixels of a block are the lanes of one pack.

namespace pliant::PLIANT_ISA {

constexpr int kBlockRows = kLanes / 4, kBlocks = kTilePixels / kLanes;

/// The bits of all rows of a block gathered at its first row.
inline uint64_t blocks_of(uint64_t rows) {
  for (int r = 1; r < kBlockRows; r *= 2) rows |= rows >> (4 * r);
  constexpr uint64_t kFirstRows = kBlockRows == 1 ? ~0ull : kBlockRows == 2 ? 0x0f0f0f0f0f0f0f0full : 0x000f000f000f000full;
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
    const Pack<T> open = Pack<T>{} + T(1), outside = Pack<T>{} + (cut_offs ? T(-1) : T(0));
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
  c.e = fma(V{} - s.slope, d, dx);
  const V across = s.precision_y * d, along = s.precision_x * c.e;
  const V exponent = fma(-along, c.e, fma(-across, d, V{} + s.log2_opacity));
  c.transmittance = transmittance;
  if constexpr (kCutOffs) {
    const V full = exp2_nonpositive(exponent), most = V{} + T(splat::kMaxAlpha);
    c.alpha = lower(full, most);
    const Mask<T> counts = c.alpha >= V{} + T(splat::kMinAlpha);
    c.alpha = where(counts, c.alpha);
    const V after = fma(-c.alpha, transmittance, transmittance);
    const Mask<T> takes = after >= V{} + T(splat::kMinTransmittance);
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
      visitor.add(local, block, contribute<T, kCutOffs>(s, state.centre_x[bit & 3] - u,
                                                        state.centre_y[(bit >> 2) / kBlockRows] - v, transmittance));
      if (kCutOffs && all_negative(transmittance)) open &= ~(1ull << bit);
    } while (blocks);
    visitor.end(local, i);
  }
  for (; i < in.count; ++i) visitor.skip(i);
}

/// The attributes of a splat, each in all lanes.
template <class T>
struct Values {
  Pack<T> base[4];
  const T* feature;
};
template <class T>
INLINE Values<T> values_of(const TileInput<T>& in, const Splat<T>& s) {
  return {{Pack<T>{} + s.color[0], Pack<T>{} + s.color[1], Pack<T>{} + s.color[2], Pack<T>{} + s.depth},
          in.features + static_cast<size_t>(s.index) * in.stride};
}

/// Sums over the splats of colour, depth and extra channels.  kChannels < 0: their number is known only at run time.
template <class T, int kChannels>
struct Blend {
  const TileInput<T>& in;
  Pack<T> (*sum)[4];
  Pack<T>* feature_sum;  // [kBlocks][channels]

  INLINE Values<T> begin(const Splat<T>& s) { return values_of(in, s); }
  INLINE void add(const Values<T>& value, int block, const Contribution<T>& c) {
    for (int k = 0; k < 4; ++k) sum[block][k] = fma(c.weight, value.base[k], sum[block][k]);
    const int channels = kChannels < 0 ? in.channels : kChannels;
    Pack<T>* to = feature_sum + block * channels;
    for (int k = 0; k < channels; ++k) to[k] = fma(c.weight, Pack<T>{} + value.feature[k], to[k]);
  }
  INLINE void end(const Values<T>&, size_t) {}
  INLINE void skip(size_t) {}
};

template <class T, bool kCutOffs, int kChannels>
void blend_channels(const TileInput<T>& in, T* transmittance, T* sums) {
  TileState<T> state(in, kCutOffs);
  Pack<T> sum[kBlocks][4] = {}, feature_sum[kChannels < 0 ? kBlocks * kMostChannelsAtOnce : kBlocks * kChannels + 1] = {};
  Blend<T, kChannels> visitor{in, sum, feature_sum};
  traverse<T, kCutOffs>(in, state, visitor);
  for (int block = 0; block < kBlocks; ++block) {
    const Pack<T> left_over = state.transmittance[block];
    pixels_from_lanes<T>(higher(left_over, -left_over), block, transmittance);
    for (int k = 0; k < 4; ++k) pixels_from_lanes<T>(sum[block][k], block, sums + k * kTilePixels);
    for (int k = 0; k < in.channels; ++k)
      pixels_from_lanes<T>(feature_sum[block * in.channels + k], block, sums + (4 + k) * kTilePixels);
  }
}

template <class T, bool kCutOffs>
void blend(const TileInput<T>& in, T* transmittance, T* sums) {
  if (in.channels == 0) return blend_channels<T, kCutOffs, 0>(in, transmittance, sums);
  if (in.channels == kMostChannelsAtOnce)
    return blend_channels<T, kCutOffs, kMostChannelsAtOnce>(in, transmittance, sums);
  blend_channels<T, kCutOffs, -1>(in, transmittance, sums);
}

/// Derivatives by the same traversal, front to back.  With g the derivative of a pixel's blended values, c_i those of a
/// splat and T_i the transmittance in front of it,
///   dL/dalpha_i = T_i (c_i . g) - rest_i / (1 - alpha_i),  rest_i = sum over what lies behind of weight (c . g),
/// and rest starts as the whole sum, known from the blended values; ds = alpha dL/dalpha = dL/d ln(alpha).
template <class T, int kChannels>
struct BlendAdjoint {
  const TileInput<T>& in;
  const Pack<T>* adj;  // [kBlocks][4 + channels]
  Pack<T>* rest;       // [kBlocks]
  Pack<T>* feature_sum;
  T* pair_gradient;
  size_t pair_stride;

  struct Local {
    Values<T> value;
    Pack<T> moment[6], sum[4];
  };

  INLINE int channels() const { return kChannels < 0 ? in.channels : kChannels; }

  INLINE Local begin(const Splat<T>& s) {
    for (int k = 0; k < channels(); ++k) feature_sum[k] = Pack<T>{};
    return {values_of(in, s), {}, {}};
  }
  INLINE void add(Local& at, int block, const Contribution<T>& c) {
    const Pack<T>* g = adj + block * (4 + channels());
    Pack<T> along = at.value.base[0] * g[0];
    for (int k = 1; k < 4; ++k) along = fma(at.value.base[k], g[k], along);
    for (int k = 0; k < 4; ++k) at.sum[k] = fma(c.weight, g[k], at.sum[k]);
    for (int k = 0; k < channels(); ++k) {
      along = fma(Pack<T>{} + at.value.feature[k], g[4 + k], along);
      feature_sum[k] = fma(c.weight, g[4 + k], feature_sum[k]);
    }
    const Pack<T> behind = fma(-c.weight, along, rest[block]);
    rest[block] = behind;
    const Pack<T> slope = c.transmittance * along - behind / (T(1) - c.alpha);
    const Pack<T> s = where(c.smooth, c.alpha * slope), se = s * c.e, sd = s * c.d;
    at.moment[kMoment] += s, at.moment[kMomentE] += se, at.moment[kMomentD] += sd;
    at.moment[kMomentEE] = fma(se, c.e, at.moment[kMomentEE]);
    at.moment[kMomentED] = fma(se, c.d, at.moment[kMomentED]);
    at.moment[kMomentDD] = fma(sd, c.d, at.moment[kMomentDD]);
  }
  INLINE void end(const Local& at, size_t entry) {
    T* to = pair_gradient + entry * pair_stride;
    Pack<T> all[kPairSlots];
    for (int k = 0; k < 6; ++k) all[k] = at.moment[k];
    for (int k = 0; k < 4; ++k) all[kAdjColor + k] = at.sum[k];
    sum_lanes(all, kPairSlots, to);
    sum_lanes(feature_sum, channels(), to + kAdjFeature);
  }
  INLINE void skip(size_t entry) {
    T* to = pair_gradient + entry * pair_stride;
    for (int k = 0; k < kPairSlots + channels(); ++k) to[k] = T(0);
  }
};

template <class T, bool kCutOffs, int kChannels>
void blend_adjoint_channels(const TileInput<T>& in, const T* adj_sums, const T* rest, T* pair_gradient,
                            size_t pair_stride, T* scratch) {
  TileState<T> state(in, kCutOffs);
  const int values = 4 + in.channels;
  Pack<T>* adj = reinterpret_cast<Pack<T>*>(scratch);
  Pack<T>* feature_sum = adj + values * kBlocks;
  Pack<T> rest_of[kBlocks];
  for (int block = 0; block < kBlocks; ++block) {
    lanes_from_pixels<T>(rest, block, rest_of[block]);
    for (int k = 0; k < values; ++k)
      lanes_from_pixels<T>(adj_sums + k * kTilePixels, block, adj[block * values + k]);
  }
  BlendAdjoint<T, kChannels> visitor{in, adj, rest_of, feature_sum, pair_gradient, pair_stride};
  traverse<T, kCutOffs>(in, state, visitor);
}

template <class T, bool kCutOffs>
void blend_adjoint(const TileInput<T>& in, const T* adj_sums, const T* rest, T* pair_gradient, size_t pair_stride,
                   T* scratch) {
  const auto run = in.channels == 0                     ? blend_adjoint_channels<T, kCutOffs, 0>
                   : in.channels == kMostChannelsAtOnce ? blend_adjoint_channels<T, kCutOffs, kMostChannelsAtOnce>
                                                        : blend_adjoint_channels<T, kCutOffs, -1>;
  run(in, adj_sums, rest, pair_gradient, pair_stride, scratch);
}

/// Calls take(pixel, Gaussian, weight) for every non-zero weight.
template <class T, class Take>
struct EachWeight {
  Take take;

  INLINE uint32_t begin(const Splat<T>& s) { return s.index; }
  INLINE void add(uint32_t index, int block, const Contribution<T>& c) {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!(c.weight[lane] > 0)) continue;
      const int y = block / 4 * kBlockRows + lane / 4, x = block % 4 * 4 + lane % 4;
      take(y * kTileSize + x, index, c.weight[lane]);
    }
  }
  INLINE void end(uint32_t, size_t) {}
  INLINE void skip(size_t) {}
};

template <class T, bool kCutOffs, class Take>
inline void for_each_weight(const TileInput<T>& in, Take take) {
  TileState<T> state(in, kCutOffs);
  EachWeight<T, Take> visitor{take};
  traverse<T, kCutOffs>(in, state, visitor);
}

template <class T, bool kCutOffs>
void count_weights(const TileInput<T>& in, uint32_t* count) {
  for_each_weight<T, kCutOffs>(in, [=](int pixel, uint32_t, T) { ++count[pixel]; });
}

template <class T, bool kCutOffs>
void write_weights(const TileInput<T>& in, const uint32_t* first, uint32_t* gaussian, T* weight) {
  uint32_t next[kTilePixels];
  for (int pixel = 0; pixel < kTilePixels; ++pixel) next[pixel] = first[pixel];
  for_each_weight<T, kCutOffs>(in, [&](int pixel, uint32_t index, T w) {
    const uint32_t entry = next[pixel]++;
    gaussian[entry] = index, weight[entry] = w;
  });
}

}  // namespace pliant::PLIANT_ISA
