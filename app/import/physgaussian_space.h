#pragma once

#include "app/import/physgaussian_config.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Gaussians that a configuration makes its object of: opacity above the threshold and, after the rotations, strictly
/// inside sim_area.  [N], 1 = object.
std::vector<uint8_t> physgaussian_members(const PhysGaussianConfig& config, const GaussianCloud& cloud);

/// A scene's place in PhysGaussian's simulation space, whose unit stands for a metre: x_sim = scale R x_scene + offset.
struct SimulationSpace {
  Mat3d R = Mat3d::Identity();
  double scale = 1;  ///< metres per scene unit
  Vec3d offset = Vec3d::Zero();

  Vec3d from_scene(const Vec3d& x) const { return scale * (R * x) + offset; }
  Vec3d to_scene(const Vec3d& x) const { return R.transpose() * (x - offset) / scale; }
};

/// Turned about the origin, scaled to the configuration's largest extent and centred at (1, 1, 1).  `members` as above;
/// throws Error{kUsage} when there are none.
SimulationSpace simulation_space(const PhysGaussianConfig& config, const GaussianCloud& cloud,
                                 const std::vector<uint8_t>& members);

}  // namespace pliant
