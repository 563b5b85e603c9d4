#pragma once

#include <algorithm>
#include <cmath>

#include "gaussians/render/tiles.h"

namespace pliant {

/// Transmittance of the pixels of one tile, row by row in packs; negative once a pixel takes nothing more.
template <class T>
struct TileTransmittance {
  static constexpr int kPacks = kTilePixels / kLanes<T>;
  Pack<T> pack[kPacks];

  T at(int pixel) const { return std::abs(pack[pixel / kLanes<T>][pixel % kLanes<T>]); }
  bool any_open() const {
    Pack<T> most = pack[0];
    for (int i = 1; i < kPacks; ++i) most = most > pack[i] ? most : pack[i];
    return any(most > Pack<T>{});
  }
};

/// Front-to-back traversal of one tile, the one place where blend weights are made.  Calls visit(splat, k, weight) with
/// the weights of pack k (pixels k * kLanes<T>... of the tile) for every splat that changes one of its pixels.
/// Pixels of the tile beyond the image get the weight 0.
template <class T, bool kCutOffs, class Visit>
void blend_tile(const TiledSplats<T>& tiled, int tile, TileTransmittance<T>& transmittance, Visit&& visit) {
  using V = Pack<T>;
  constexpr int kPacksPerRow = kTileSize / kLanes<T>, kCheckEvery = 16, kAhead = 12;
  constexpr T kMargin = T(0.01);
  const int left = tile % tiled.tiles_x * kTileSize, top = tile / tiled.tiles_x * kTileSize;
  const int columns = std::min(kTileSize, tiled.width - left), rows = std::min(kTileSize, tiled.height - top);
  for (int pixel = 0; pixel < kTilePixels; ++pixel) {
    const bool inside = pixel % kTileSize < columns && pixel / kTileSize < rows;
    transmittance.pack[pixel / kLanes<T>][pixel % kLanes<T>] = inside ? T(1) : kCutOffs ? T(-1) : T(0);
  }
  V centre[kPacksPerRow];
  for (int x = 0; x < kTileSize; ++x) centre[x / kLanes<T>][x % kLanes<T>] = T(left + x) + T(0.5);

  const uint32_t begin = tiled.tile_start[tile], end = tiled.tile_start[tile + 1];
  for (uint32_t entry = begin; entry < end; ++entry) {
    if (kCutOffs && (entry - begin) % kCheckEvery == 0 && !transmittance.any_open()) break;
    if (entry + kAhead < end) __builtin_prefetch(&tiled.splats[tiled.tile_splat[entry + kAhead]]);
    const Splat<T>& s = tiled.splats[tiled.tile_splat[entry]];
    const T middle = s.v - T(top) - T(0.5);
    const int first = static_cast<int>(bounded(std::ceil(middle - s.half_height), T(0), T(rows)));
    const int last = static_cast<int>(bounded(std::floor(middle + s.half_height), T(-1), T(rows - 1)));
    for (int y = first; y <= last; ++y) {
      const SplatRow<T> row = splat_row(s.u, s.v, s.slope, s.half_inverse_y, T(top + y) + T(0.5));
      const T squared = s.variance_x * (s.reach + 2 * row.power);
      if (!(squared > T(0))) continue;
      const T half_width = std::sqrt(squared) + kMargin, x = row.x0 - T(left) - T(0.5);
      const int from = static_cast<int>(bounded(x - half_width + 1, T(0), T(columns))) / kLanes<T>;
      const int to =
          static_cast<int>(bounded(x + half_width, T(-kLanes<T>), T(columns - 1)) + T(kLanes<T>)) / kLanes<T>;
      for (int p = from; p < to; ++p) {
        const int k = y * kPacksPerRow + p;
        V t = transmittance.pack[k];
        const V alpha = splat_alpha<kCutOffs>(s.opacity, s.half_inverse_x, row, centre[p]);
        const V weight = blend<kCutOffs, T>(alpha, t);
        transmittance.pack[k] = t;
        if (any(weight > V{})) visit(s, k, weight);
      }
    }
  }
}

}  // namespace pliant
