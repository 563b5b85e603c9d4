#pragma once

#include <cstddef>

#include "gaussians/render/splat.h"
#include "gaussians/simd/instruction_set.h"

namespace pliant {

/// A camera as the kernels use it.
template <class T>
struct View {
  T R[3][3], t[3], centre[3];      ///< cam_from_world; camera centre in the world
  T fx, fy, cx, cy;                ///< pixels
  T low_x, high_x, low_y, high_y;  ///< bounds of x/z and y/z at which the Jacobian is taken
  int width, height;
  T blur;  ///< variance of the low-pass filter (px^2)
};

/// Derivatives with respect to the camera, as free entries of R, t and centre.
template <class T>
struct ViewGradient {
  T R[3][3] = {}, t[3] = {}, centre[3] = {};

  void operator+=(const ViewGradient& other) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) R[i][k] += other.R[i][k];
      t[i] += other.t[i];
      centre[i] += other.centre[i];
    }
  }
};

/// The arrays of a cloud: position [N, 3], rotation [N, 4], log_scale [N, 3], opacity_logit [N], sh [N, K, 3].
template <class T>
struct CloudInput {
  const T *position, *rotation, *log_scale, *opacity_logit, *sh;
  int sh_degree;
};
/// Arrays of the same shapes, to which derivatives are added; covariance [N, 3, 3] or null.
template <class T>
struct CloudGradient {
  T *position, *rotation, *log_scale, *opacity_logit, *sh, *covariance;
};

/// What projection reads: Gaussians [begin, end).
template <class T>
struct ProjectInput {
  CloudInput<T> cloud;
  View<T> view;
  bool antialiased;
  size_t begin, end;
};
/// Its reverse: for splats of the Gaussians index[0..count), no two the same, the sums over their pixels
/// [count, kPairSlots].
template <class T>
struct ProjectAdjointInput {
  CloudInput<T> cloud;
  View<T> view;
  bool antialiased;
  const uint32_t* index;
  const T* sums;
  size_t count;
};

/// One tile as the kernels see it.  Only plain data crosses into the files of an instruction set.
template <class T>
struct TileInput {
  const Splat<T>* splats;
  const TileEntry* entries;  ///< of this tile, front to back
  size_t count;
  int left, top, columns, rows;  ///< first pixel, and how many of its pixels lie in the image
  const T* features;             ///< [N, stride] by the index of the Gaussian; `channels` of each row are blended
  int stride, channels;
};

/// What binning reads and writes: pairs of the splats order[begin..end) with the tiles [first_tile, last_tile).
template <class T>
struct BinInput {
  const Splat<T>* splats;
  const uint32_t* order;
  size_t begin, end;
  int width, height, tiles_x, first_tile, last_tile;
};
struct TilePair {
  uint64_t blocks;
  uint32_t splat, tile;  ///< tile counted from first_tile
};

/// The loops that depend on the instruction set.  Pixel arrays are [kTilePixels], row by row.
template <class T>
struct BlendKernels {
  /// Writes the splats of the Gaussians that can be seen, in their order, and returns their number; `splats` has room
  /// for all.  Left out are those nearer than kNear, not finite, fainter than the smallest alpha, or outside the
  /// picture. The tiles of a splat are those of the box around the ellipse alpha >= 1/255; without cut-offs all tiles.
  size_t (*project)(const ProjectInput<T>&, Splat<T>* splats);

  /// Adds the derivatives of Gaussians and camera.
  void (*project_adjoint)(const ProjectAdjointInput<T>&, const CloudGradient<T>&, ViewGradient<T>&);

  /// Writes the pairs in which a splat can change a pixel, splat by splat, and counts those of each tile
  /// [last_tile - first_tile] and of each splat [by position].  Returns their number; `pairs` has room for every tile
  /// that a bounding box touches.
  size_t (*bin)(const BinInput<T>&, TilePair* pairs, uint32_t* count_of_tile, uint32_t* count_of_splat);

  /// sums [4 + channels][kTilePixels]: red, green, blue, depth and the extra channels blended front to back;
  /// transmittance [kTilePixels]: what is left for the background.
  void (*blend)(const TileInput<T>&, T* transmittance, T* sums);

  /// Reverse of `blend`.  adj_sums [4 + channels][kTilePixels]; rest [kTilePixels]: the scalar product of the blended
  /// values with their derivatives, including what the transmittance left over contributes.  Writes kPairSlots +
  /// channels derivatives of each entry at pair_gradient + entry * pair_stride.  scratch [(4 + channels) kTilePixels].
  void (*blend_adjoint)(const TileInput<T>&, const T* adj_sums, const T* rest, T* pair_gradient, size_t pair_stride,
                        T* scratch);

  /// Number of non-zero blend weights of each pixel.
  void (*count_weights)(const TileInput<T>&, uint32_t* count);
  /// Writes them, each pixel's front to back from next[pixel] on.
  void (*write_weights)(const TileInput<T>&, const uint32_t* next, uint32_t* gaussian, T* weight);
};

template <class T, bool kCutOffs>
const BlendKernels<T>& blend_kernels(InstructionSet set);

namespace baseline {
template <class T, bool kCutOffs>
const BlendKernels<T>& blend_kernels();
}
namespace avx2 {
template <class T, bool kCutOffs>
const BlendKernels<T>& blend_kernels();
}

}  // namespace pliant
