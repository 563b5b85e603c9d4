#pragma once

#include <span>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"

namespace pliant {

/// Conventions of the reference 3DGS rasteriser (Kerbl et al. 2023, and its released code).
struct RenderOptions {
  Vec3f background = Vec3f::Zero();
  bool antialiased = false;  ///< opacity compensation for scenes trained with mip-splatting (Yu et al. 2024)
};

struct RenderResult {
  ImageF color;     ///< [H, W, 3] including the background; not clamped
  ImageF depth;     ///< [H, W, 1] sum of blend weight * z; divide by alpha for the mean depth (scene units)
  ImageF alpha;     ///< [H, W, 1] accumulated opacity, 1 - final transmittance
  ImageF features;  ///< [H, W, C] blended extra channels; empty when there are none
};

/// Picture of `cloud` from `camera`.  `features` [N, channels] are blended like colour, without a background.
/// Equal bit for bit for any number of threads.
RenderResult render(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options = {},
                    std::span<const float> features = {}, int channels = 0);

}  // namespace pliant
