#pragma once

#include <memory>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/portable.h"
#include "gaussians/render/blend.h"
#include "gaussians/render/picture_frame.h"
#include "gaussians/simd/instruction_set.h"

namespace pliant {

/// Memory that is not set to zero before it is written.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    ::new (static_cast<void*>(at)) U(std::forward<Args>(args)...);
  }
};

/// Splats of one picture in front-to-back order.
template <class T>
struct ProjectedSplats {
  int width = 0, height = 0, tiles_x = 0, tiles_y = 0;
  std::vector<Splat<T>, UnsetAllocator<Splat<T>>> splats;  ///< those that may be seen, in the order of the cloud
  std::vector<uint32_t> order;  ///< positions in `splats`, ascending depth; equal depths in the order of the cloud
  std::vector<int> bands;       ///< tiles [bands[b], bands[b + 1]) are binned together, which bounds the memory

  int tiles() const { return tiles_x * tiles_y; }
};

/// For every tile of a band the splats that can change one of its pixels.
struct TileLists {
  int first_tile = 0, last_tile = 0;
  std::vector<uint32_t> start;          ///< [tiles of the band + 1]
  std::vector<TileEntry> entries;       ///< of a tile front to back
  std::vector<uint32_t> first_pair;     ///< [splats + 1] where the pairs of a splat begin
  std::vector<uint32_t> entry_of_pair;  ///< entries of a splat, ascending tiles
};

/// Most pairs of splat and tile that are held at a time, unless one tile alone has more: 36 bytes each while they are
/// made, 20 after.  A picture whose splats overlap more tiles is made in several bands.
constexpr size_t kMostPairs = size_t{8} << 20;

/// Projects, culls and sorts by depth.  Gaussians that are not finite after projection (NaN, overflowing scales) are
/// left out.  `frame`: the whole picture, if the camera draws a part of one.  Memory: 72 bytes per Gaussian in view in
/// float, twice that for a moment.
template <class T, bool kCutOffs>
ProjectedSplats<T> project_splats(const CloudOf<T>& cloud, const Camera& camera, bool antialiased, size_t most_pairs,
                                  InstructionSet set = best_instruction_set(),
                                  double screen_variance = splat::kScreenVariance,
                                  const std::optional<PictureFrame>& frame = {});

/// A splat enters exactly the tiles in which the ellipse alpha >= 1/255 covers part of a pixel row (the reference
/// enters all tiles that a 3 sigma square touches, which can miss the rim between 3 and 3.33 sigma of nearly opaque
/// splats). Without cut-offs every splat enters every tile.
template <class T, bool kCutOffs>
TileLists bin_splats(const ProjectedSplats<T>& projected, int band, InstructionSet set);

}  // namespace pliant
