#pragma once

#include <string>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"

namespace pliant {

/// E on the object: its Gaussians from 8 sides, tinted by E of the nearest of the solid samples, with a legend.
/// `positions` [S, 3] scene units, `young` [S] Pa.
ImageF stiffness_sheet(const GaussianCloud& object, const Eigen::Vector3d& up, const std::vector<Vec3f>& positions,
                       const std::vector<float>& young, const std::string& title);

}  // namespace pliant
