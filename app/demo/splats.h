#pragma once

#include <vector>

#include "app/demo/stage.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Gaussians on the surfaces of the stage, with the truth about each.
struct StageSplats {
  GaussianCloud cloud;
  std::vector<Vec3f> surface;   ///< [N] point of the surface; centres of rounded things lie a little inside
  std::vector<uint32_t> label;  ///< [N] id
  std::vector<int> material;    ///< [N] of the object, -1 elsewhere
};

/// About `count` flat discs of one colour, evenly spread: a quarter on the object, a tenth on the other objects, the
/// rest on table and wall.  A disc exists only where at least one camera sees its surface point.
StageSplats make_splats(const Stage& stage, const std::vector<Camera>& cameras, int count, uint64_t seed);

/// Whether a camera sees the surface point x with normal n (world): inside its picture, facing it, nothing between.
bool sees(const Stage& stage, const Camera& camera, const Vec3d& x, const Vec3d& normal);

}  // namespace pliant
