#pragma once

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"

namespace pliant {

/// Picture made the slow way, in double precision, for comparison only: every pixel visits every Gaussian in order of
/// depth.  Formulas from Kerbl et al. 2023 (eq. 3 to 6) with the constants of its released code.
struct ReferencePicture {
  Image<double> color, depth, alpha;
  /// 1 where a decision (alpha against 1/255, transmittance against 1e-4, order of depths) was so close that float
  /// arithmetic may decide otherwise.
  Image<uint8_t> close_call;
};

ReferencePicture render_slowly(const GaussianCloud& cloud, const Camera& camera, const Vec3f& background,
                               bool antialiased);

}  // namespace pliant
