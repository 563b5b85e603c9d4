#include "gaussians/render/blend_weights.h"

#include "gaussians/base/error.h"
#include "gaussians/render/blend_tile.h"

namespace pliant {
namespace {

struct Entry {
  uint32_t pixel, gaussian;  // pixel of the image
  float weight;
};

}  // namespace

BlendWeights blend_weights(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options) {
  const TiledSplats<float> tiled = tile_splats<float, true>(cloud, camera, options.antialiased);
  BlendWeights out;
  out.width = camera.width, out.height = camera.height;
  std::vector<uint32_t> count(out.pixels(), 0);
  std::vector<std::vector<Entry>> entries(tiled.tiles());
  parallel_for(tiled.tiles(), [&](std::ptrdiff_t tile) {
    const int left = static_cast<int>(tile) % tiled.tiles_x * kTileSize;
    const int top = static_cast<int>(tile) / tiled.tiles_x * kTileSize;
    TileTransmittance<float> transmittance;
    blend_tile<float, true>(tiled, static_cast<int>(tile), transmittance, [&](const Splat<float>& s, int k, FloatPack weight) {
      for (int lane = 0; lane < kLanes<float>; ++lane) {
        if (!(weight[lane] > 0)) continue;
        const int pixel = k * kLanes<float> + lane, x = left + pixel % kTileSize, y = top + pixel / kTileSize;
        const uint32_t of_image = static_cast<uint32_t>(y * out.width + x);
        entries[tile].push_back({of_image, s.index, weight[lane]});
        ++count[of_image];
      }
    });
  });
  out.row_start.resize(out.pixels() + 1);
  size_t total = 0;
  for (size_t pixel = 0; pixel < out.pixels(); ++pixel) {
    out.row_start[pixel] = static_cast<uint32_t>(total);
    total += count[pixel];
    count[pixel] = out.row_start[pixel];
  }
  CHECK_MSG(total < UINT32_MAX, "too many blend weights in one view");
  out.row_start[out.pixels()] = static_cast<uint32_t>(total);
  out.gaussian.resize(total), out.weight.resize(total);
  parallel_for(tiled.tiles(), [&](std::ptrdiff_t tile) {
    for (const Entry& entry : entries[tile]) {
      const uint32_t slot = count[entry.pixel]++;
      out.gaussian[slot] = entry.gaussian, out.weight[slot] = entry.weight;
    }
    std::vector<Entry>().swap(entries[tile]);
  });
  return out;
}

}  // namespace pliant
