#pragma once

#include <span>
#include <string>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// A region of the scene that stands for the object: --aabb x0,y0,z0,x1,y1,z1 or --sphere x,y,z,r (scene units).
struct SelectionShape {
  static constexpr uint32_t kObject = 1, kRest = 2;  ///< ids of what lies inside and of the others

  bool sphere = false;
  Box box;
  Vec3f centre = Vec3f::Zero();
  float radius = 0;

  /// From the numbers of the option; throws Error{kUsage} naming the option and the value.
  static SelectionShape from_aabb(const std::vector<double>& values);
  static SelectionShape from_sphere(const std::vector<double>& values);
  bool contains(const Vec3f& x) const;
};

/// The Gaussians whose centre lies inside [N].  Throws Error{kUsage} when there are none.
std::vector<uint8_t> shape_members(const SelectionShape& shape, const GaussianCloud& cloud);

/// The segmentation in which the Gaussians with `member` [N] != 0 are "object", the others "rest".  `option` is named
/// in errors, `antialiased` as in Segmentation.  Throws Error{kUsage} when no camera sees them.
Segmentation segmentation_of_members(const std::string& option, std::span<const uint8_t> member,
                                     const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                                     bool antialiased = false);

}  // namespace pliant
