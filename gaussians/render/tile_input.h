#pragma once

#include <algorithm>
#include <span>

#include "gaussians/render/tiles.h"

namespace pliant {

/// Tile number `tile` of a band, for the kernels.
template <class T>
TileInput<T> tile_input(const ProjectedSplats<T>& projected, const TileLists& lists, int tile,
                        std::span<const T> features = {}, int channels = 0) {
  const int left = (lists.first_tile + tile) % projected.tiles_x * kTileSize;
  const int top = (lists.first_tile + tile) / projected.tiles_x * kTileSize;
  return {projected.splats.data(),
          lists.entries.data() + lists.start[tile],
          lists.start[tile + 1] - lists.start[tile],
          left,
          top,
          std::min(kTileSize, projected.width - left),
          std::min(kTileSize, projected.height - top),
          features.data(),
          channels,
          channels};
}

/// Calls visit(x, y, pixel of the tile) for every pixel of the tile that lies in the image.
template <class T, class Visit>
void for_each_pixel(const TileInput<T>& in, Visit&& visit) {
  for (int y = 0; y < in.rows; ++y)
    for (int x = 0; x < in.columns; ++x) visit(in.left + x, in.top + y, y * kTileSize + x);
}

}  // namespace pliant
