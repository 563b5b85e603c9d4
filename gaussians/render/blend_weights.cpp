#include "gaussians/render/blend_weights.h"

#include "gaussians/base/error.h"
#include "gaussians/render/blend_tile.h"

namespace pliant {
namespace {

// Calls visit(slot, splat, weights) for every pack with a non-zero weight, front to back, tiles in parallel.  `slot` is
// the position of its first pixel in an array [tiles][pixels of a tile].
template <class Visit>
void for_each_pack(const TiledSplats<float>& tiled, Visit&& visit) {
  parallel_for(tiled.tiles(), [&](std::ptrdiff_t tile) {
    TileTransmittance<float> transmittance;
    blend_tile<float, true>(tiled, static_cast<int>(tile), transmittance,
                            [&](const Splat<float>& s, int k, FloatPack weight) {
                              visit(static_cast<size_t>(tile) * kTilePixels + k * kLanes<float>, s, weight);
                            });
  });
}

}  // namespace

BlendWeights blend_weights(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options) {
  const TiledSplats<float> tiled = tile_splats<float, true>(cloud, camera, options.antialiased);
  BlendWeights out;
  out.width = camera.width, out.height = camera.height;
  // Two traversals, to count and to write, are faster than one that stores entries until their place is known.
  std::vector<uint32_t> next(static_cast<size_t>(tiled.tiles()) * kTilePixels, 0);
  for_each_pack(tiled, [&](size_t slot, const Splat<float>&, FloatPack weight) {
    for (int lane = 0; lane < kLanes<float>; ++lane) next[slot + lane] += weight[lane] > 0;
  });
  out.row_start.reserve(out.pixels() + 1);
  size_t total = 0;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const size_t tile = static_cast<size_t>(y / kTileSize) * tiled.tiles_x + x / kTileSize;
      uint32_t& slot = next[tile * kTilePixels + y % kTileSize * kTileSize + x % kTileSize];
      const uint32_t count = slot;
      out.row_start.push_back(slot = static_cast<uint32_t>(total));
      total += count;
    }
  }
  CHECK_MSG(total < UINT32_MAX, "too many blend weights in one view");
  out.row_start.push_back(static_cast<uint32_t>(total));
  out.gaussian.resize(total), out.weight.resize(total);
  for_each_pack(tiled, [&](size_t slot, const Splat<float>& s, FloatPack weight) {
    for (int lane = 0; lane < kLanes<float>; ++lane) {
      if (!(weight[lane] > 0)) continue;
      const uint32_t entry = next[slot + lane]++;
      out.gaussian[entry] = s.index, out.weight[entry] = weight[lane];
    }
  });
  return out;
}

}  // namespace pliant
