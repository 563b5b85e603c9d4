#pragma once

#include "gaussians/render/tile_traversal.h"

// Blending of one tile, forward and reverse, and its weights as numbers.

namespace pliant::PLIANT_ISA {

/// The attributes of a splat, each in all lanes.
template <class T>
struct Values {
  Pack<T> base[4];
  const T* feature;
};
template <class T>
INLINE Values<T> values_of(const TileInput<T>& in, const Splat<T>& s) {
  return {{all<Pack<T>>(s.color[0]), all<Pack<T>>(s.color[1]), all<Pack<T>>(s.color[2]), all<Pack<T>>(s.depth)},
          in.features + static_cast<size_t>(s.index) * in.stride};
}

/// Sums over the splats of colour, depth and extra channels.  kChannels < 0: their number is known only at run time.
/// Weights of a few splats wait until those of a block can be added while its sums are in registers.
template <class T, int kChannels>
struct Blend {
  static constexpr int kBatch = kChannels == 0 ? 1 : 16, kAtOnce = 8;
  const TileInput<T>& in;
  Pack<T> (*sum)[4];
  Pack<T>* feature_sum;  // [kBlocks][channels]
  Pack<T> weight[kBlocks][kBatch];
  const T* feature[kBlocks][kBatch];
  int waiting[kBlocks] = {};
  int splats = 0;

  INLINE Values<T> begin(const Splat<T>& s) {
    const Values<T> value = values_of(in, s);
    if (kChannels != 0) __builtin_prefetch(value.feature);
    return value;
  }
  INLINE void add(const Values<T>& value, int block, const Contribution<T>& c) {
    for (int k = 0; k < 4; ++k) sum[block][k] = fma(c.weight, value.base[k], sum[block][k]);
    if (kChannels == 0) return;
    const int n = waiting[block]++;
    weight[block][n] = c.weight;
    feature[block][n] = value.feature;
  }
  INLINE void end(const Values<T>&, size_t) {
    if (kChannels != 0 && ++splats == kBatch) add_features();
  }
  INLINE void skip(size_t) {}

  void add_features() {
    const int channels = kChannels < 0 ? in.channels : kChannels;
    for (int block = 0; block < kBlocks; ++block) {
      if (waiting[block] == 0) continue;
      int first = 0;
      for (; first + kAtOnce <= channels; first += kAtOnce)
        add_some<kAtOnce>(block, first, feature_sum + block * channels + first);
      for (; first < channels; ++first) add_some<1>(block, first, feature_sum + block * channels + first);
      waiting[block] = 0;
    }
    splats = 0;
  }
  template <int kCount>
  INLINE void add_some(int block, int first, Pack<T>* to) const {
    Pack<T> part[kCount];
    for (int k = 0; k < kCount; ++k) part[k] = to[k];
    for (int i = 0; i < waiting[block]; ++i) {
      const Pack<T> w = weight[block][i];
      const T* from = feature[block][i] + first;
      for (int k = 0; k < kCount; ++k) part[k] = fma(w, all<Pack<T>>(from[k]), part[k]);
    }
    for (int k = 0; k < kCount; ++k) to[k] = part[k];
  }
};

template <class T, bool kCutOffs, int kChannels>
void blend_channels(const TileInput<T>& in, T* transmittance, T* sums) {
  TileState<T> state(in, kCutOffs);
  Pack<T> sum[kBlocks][4] = {},
          feature_sum[kChannels < 0 ? kBlocks * kMostChannelsAtOnce : kBlocks * kChannels + 1] = {};
  Blend<T, kChannels> visitor{in, sum, feature_sum, {}, {}};
  traverse<T, kCutOffs>(in, state, visitor);
  if (kChannels != 0) visitor.add_features();
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
  static constexpr int kAtOnce = 8;
  const TileInput<T>& in;
  const Pack<T>* adj;  // [kBlocks][4 + channels]
  Pack<T>* rest;       // [kBlocks]
  T* pair_gradient;
  size_t pair_stride;

  struct Local {
    Values<T> value;
    Pack<T> moment[6], sum[4];
    int blocks;  // so far; their weights wait for the sums of the extra channels
  };
  Pack<T> weight[kBlocks];
  int block_of_weight[kBlocks];

  INLINE int channels() const { return kChannels < 0 ? in.channels : kChannels; }

  INLINE Local begin(const Splat<T>& s) { return {values_of(in, s), {}, {}, 0}; }
  INLINE void add(Local& at, int block, const Contribution<T>& c) {
    const Pack<T>* g = adj + block * (4 + channels());
    Pack<T> along = at.value.base[0] * g[0];
    for (int k = 1; k < 4; ++k) along = fma(at.value.base[k], g[k], along);
    for (int k = 0; k < 4; ++k) at.sum[k] = fma(c.weight, g[k], at.sum[k]);
    if (kChannels != 0) {
      along += along_features(at.value.feature, g + 4);
      weight[at.blocks] = c.weight;
      block_of_weight[at.blocks++] = block;
    }
    const Pack<T> behind = fma(-c.weight, along, rest[block]);
    rest[block] = behind;
    const Pack<T> slope = c.transmittance * along - behind / (T(1) - c.alpha);
    const Pack<T> s = where(c.smooth, c.alpha * slope), se = s * c.e, sd = s * c.d;
    at.moment[kMoment] += s;
    at.moment[kMomentE] += se;
    at.moment[kMomentD] += sd;
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
    for (int first = 0; first < channels(); first += kAtOnce) sum_features(at, first, to + kAdjFeature + first);
  }
  INLINE void skip(size_t entry) {
    T* to = pair_gradient + entry * pair_stride;
    for (int k = 0; k < kPairSlots + channels(); ++k) to[k] = T(0);
  }

  // Scalar product of the extra channels with their derivatives, in four chains that run side by side.
  INLINE Pack<T> along_features(const T* feature, const Pack<T>* g) const {
    Pack<T> part[4] = {};
    int k = 0;
    for (; k + 4 <= channels(); k += 4)
      for (int j = 0; j < 4; ++j) part[j] = fma(all<Pack<T>>(feature[k + j]), g[k + j], part[j]);
    for (; k < channels(); ++k) part[0] = fma(all<Pack<T>>(feature[k]), g[k], part[0]);
    return (part[0] + part[1]) + (part[2] + part[3]);
  }
  // Derivatives of a few extra channels, as many as fit the registers, over all blocks of a splat.
  INLINE void sum_features(const Local& at, int first, T* to) const {
    const int count = channels() - first < kAtOnce ? channels() - first : kAtOnce;
    Pack<T> part[kAtOnce] = {};
    for (int i = 0; i < at.blocks; ++i) {
      const Pack<T> w = weight[i];
      const Pack<T>* g = adj + block_of_weight[i] * (4 + channels()) + 4 + first;
      if (count == kAtOnce) {
        for (int k = 0; k < kAtOnce; ++k) part[k] = fma(w, g[k], part[k]);
      } else {
        for (int k = 0; k < count; ++k) part[k] = fma(w, g[k], part[k]);
      }
    }
    sum_lanes(part, count, to);
  }
};

template <class T, bool kCutOffs, int kChannels>
void blend_adjoint_channels(const TileInput<T>& in, const T* adj_sums, const T* rest, T* pair_gradient,
                            size_t pair_stride, T* scratch) {
  TileState<T> state(in, kCutOffs);
  const int values = 4 + in.channels;
  Pack<T>* adj = reinterpret_cast<Pack<T>*>(scratch);
  Pack<T> rest_of[kBlocks];
  for (int block = 0; block < kBlocks; ++block) {
    lanes_from_pixels<T>(rest, block, rest_of[block]);
    for (int k = 0; k < values; ++k) lanes_from_pixels<T>(adj_sums + k * kTilePixels, block, adj[block * values + k]);
  }
  BlendAdjoint<T, kChannels> visitor{in, adj, rest_of, pair_gradient, pair_stride, {}, {}};
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
    gaussian[entry] = index;
    weight[entry] = w;
  });
}

}  // namespace pliant::PLIANT_ISA
