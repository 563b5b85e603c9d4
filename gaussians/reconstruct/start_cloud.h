#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// 1.1 times the largest distance of a camera from their mean: the length that rates and thresholds are relative to
/// (the reference 3DGS code).  For cameras at one point, the length 1.
double camera_extent(const std::vector<Camera>& cameras);

/// Round Gaussians at points [N, 3] with colours [N, 3] in [0, 1]: standard deviations the root mean square distance to
/// the three nearest, opacity 0.1.
GaussianCloud cloud_from_points(std::span<const Vec3f> position, std::span<const Vec3f> color);

/// `count` grey Gaussians uniformly in the ball that all cameras look at: centred on the point nearest to their axes,
/// with the radius that fills the mean picture.
GaussianCloud random_cloud(const std::vector<Camera>& cameras, size_t count, uint64_t seed);

}  // namespace pliant
