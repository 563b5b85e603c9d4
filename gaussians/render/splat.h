#pragma once

#include <cstddef>
#include <cstdint>

#include "gaussians/base/near_plane.h"

namespace pliant {

/// Constants of the reference 3DGS rasteriser; forward and reverse passes use the same ones.
namespace splat {
constexpr double kNear = kNearPlane;     ///< Gaussians nearer than this are not drawn (scene units)
constexpr double kFrustumClamp = 1.3;    ///< the Jacobian is taken inside the frustum widened by this factor
constexpr double kScreenVariance = 0.3;  ///< low-pass filter added to the 2D covariance (px^2)
constexpr double kMaxAlpha = 0.99;
constexpr double kMinAlpha = 1.0 / 255;      ///< smaller contributions are skipped
constexpr double kMinTransmittance = 1e-4;   ///< blending ends before the transmittance falls below this
constexpr double kMinCompensation = 2.5e-5;  ///< smallest ratio of determinants in antialiased rendering
}  // namespace splat

constexpr int kTileSize = 16;  ///< px; tiles start at the image's top left corner
constexpr int kTilePixels = kTileSize * kTileSize;
constexpr int kMostChannelsAtOnce = 16;  ///< extra channels of one forward traversal; its sums stay in the first cache

/// What blending needs of a projected Gaussian; one cache line in float.  Its contribution at (x, y) is
///   alpha = 2^(log2_opacity - precision_x e^2 - precision_y d^2),  d = y - v,  e = x - u - slope d:
/// the quadratic form -(1/2) (x - u, y - v) covariance^-1 (x - u, y - v)^T completed to squares, which keeps thin
/// splats from cancellation and the exponent from being positive.
template <class T>
struct alignas(16 * sizeof(T)) Splat {
  T u, v, depth;  ///< mean (px), z in the camera frame
  T slope;        ///< covariance xy / yy: how the centre of a pixel row shifts with y
  T precision_x;  ///< log2(e) / (2 variance of x at a given y)
  T precision_y;  ///< log2(e) / (2 yy)
  T log2_opacity;
  T color[3];
  uint32_t index;                                           ///< of the Gaussian in its cloud
  uint16_t first_column, last_column, first_row, last_row;  ///< tiles that its bounding box touches
};

/// A splat in the list of a tile.
struct TileEntry {
  uint64_t blocks;  ///< bit 4 y + x / 4: the splat can change one of the pixels x..x+3 of row y of the tile
  uint32_t splat;   ///< position among the projected splats
};

/// Slots of the derivatives that one pair of splat and tile hands on: moments of s = dL/d ln(alpha) summed over pixels,
/// and the derivatives of the blended attributes.
enum PairSlot {
  kMoment = 0,  ///< sum s
  kMomentE,     ///< sum s e
  kMomentD,     ///< sum s d
  kMomentEE,    ///< sum s e e
  kMomentED,    ///< sum s e d
  kMomentDD,    ///< sum s d d
  kAdjColor,    ///< three of them
  kAdjDepth = kAdjColor + 3,
  kAdjFeature,  ///< as many as there are extra channels
  kPairSlots = kAdjFeature
};

}  // namespace pliant
