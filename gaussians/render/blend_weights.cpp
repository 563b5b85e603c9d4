#include "gaussians/render/blend_weights.h"

#include "gaussians/base/error.h"
#include "gaussians/render/tile_input.h"

namespace pliant {

BlendWeights blend_weights(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options) {
  const ProjectedSplats<float> projected =
      project_splats<float, true>(cloud, camera, options.antialiased, options.most_pairs, options.instruction_set,
                                  options.screen_variance, options.frame);
  const BlendKernels<float>& kernels = blend_kernels<float, true>(options.instruction_set);
  BlendWeights out;
  out.width = camera.width;
  out.height = camera.height;
  TileLists lists;
  int binned = -1;  // the band that `lists` holds
  const auto for_each_tile = [&](auto&& visit) {
    for (int band = 0; band + 1 < static_cast<int>(projected.bands.size()); ++band) {
      if (band != binned) lists = bin_splats<float, true>(projected, band, options.instruction_set);
      binned = band;
      parallel_for(lists.last_tile - lists.first_tile, [&](std::ptrdiff_t tile) {
        visit(lists.first_tile + tile, tile_input(projected, lists, static_cast<int>(tile)));
      });
    }
  };
  // Two traversals, to count and to write, are faster than one that stores entries until their place is known.
  std::vector<uint32_t> next(static_cast<size_t>(projected.tiles()) * kTilePixels, 0);
  for_each_tile([&](std::ptrdiff_t tile, const TileInput<float>& in) {
    kernels.count_weights(in, next.data() + tile * kTilePixels);
  });
  out.row_start.reserve(out.pixels() + 1);
  size_t total = 0;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const size_t tile = static_cast<size_t>(y / kTileSize) * projected.tiles_x + x / kTileSize;
      uint32_t& slot = next[tile * kTilePixels + y % kTileSize * kTileSize + x % kTileSize];
      const uint32_t count = slot;
      out.row_start.push_back(slot = static_cast<uint32_t>(total));
      total += count;
    }
  }
  CHECK_MSG(total < UINT32_MAX, "too many blend weights in one view");
  out.row_start.push_back(static_cast<uint32_t>(total));
  out.gaussian.resize(total);
  out.weight.resize(total);
  for_each_tile([&](std::ptrdiff_t tile, const TileInput<float>& in) {
    kernels.write_weights(in, next.data() + tile * kTilePixels, out.gaussian.data(), out.weight.data());
  });
  return out;
}

}  // namespace pliant
