#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/render/splat_kernels.h"

namespace pliant {

constexpr int kTileSize = 16;  ///< px; tiles start at the image's top left corner
constexpr int kTilePixels = kTileSize * kTileSize;

/// What blending needs of a projected Gaussian; one cache line in float.
template <class T>
struct alignas(16 * sizeof(T)) Splat {
  T u, v, depth;     ///< mean (px), z in the camera frame
  T slope;           ///< covariance xy / yy: how the centre of a pixel row shifts with y
  T half_inverse_x;  ///< 1 / (2 variance_x)
  T half_inverse_y;  ///< 1 / (2 yy)
  T variance_x;      ///< variance of x at a given y, determinant / yy
  T half_height;     ///< half extent in y (px) of the pixels that it can change
  T reach;           ///< squared Mahalanobis distance at which alpha falls below 1/255, slightly widened
  T opacity;
  T color[3];
  uint32_t index;  ///< of the Gaussian in its cloud
};

/// Splats in front-to-back order and, for every tile, those that can change one of its pixels.
template <class T>
struct TiledSplats {
  int width = 0, height = 0, tiles_x = 0, tiles_y = 0;
  std::vector<Splat<T>> splats;      ///< ascending depth; equal depths in the order of the cloud
  std::vector<uint32_t> tile_start;  ///< [tiles + 1]
  std::vector<uint32_t> tile_splat;  ///< positions in `splats`, ascending within a tile

  int tiles() const { return tiles_x * tiles_y; }
};

/// Projects, culls, sorts and bins.  A splat enters exactly the tiles in which the ellipse alpha >= 1/255 covers a
/// pixel row's span (the reference enters all tiles that a 3 sigma square touches, which can miss the rim between 3
/// and 3.33 sigma of nearly opaque splats).  Without cut-offs every splat enters every tile. Gaussians that are not
/// finite after projection (NaN, overflowing scales) are left out.
template <class T, bool kCutOffs>
TiledSplats<T> tile_splats(const GaussianCloud& cloud, const Camera& camera, bool antialiased);

}  // namespace pliant
