#pragma once

#include <span>
#include <string>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/labels/mask_set.h"
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
  /// Whether x lies inside the shape grown by `margin` on every side.
  bool contains(const Vec3f& x, float margin = 0) const;
  /// Diagonal of the box or diameter of the sphere.
  float extent() const { return sphere ? 2 * radius : box.size().norm(); }
};

/// Id masks of chosen Gaussians (`member` [N] != 0): 1 = object, 2 = rest, the one with the larger blended weight; 0
/// where accumulated opacity < 0.5.  `option` is named in errors.  Throws Error{kUsage} when no camera sees them.
MaskSet member_masks(const std::string& option, std::span<const uint8_t> member, const GaussianCloud& cloud,
                     const std::vector<Camera>& cameras);

/// Gaussians labelled object whose `keep` [N] is 0 become rest.  Returns how many.
size_t restrict_to_members(std::span<const uint8_t> keep, Segmentation& segmentation);

/// Id masks of a geometric selection, so that it takes the same path as masks: Gaussians with their centre inside are
/// "object", the others "rest"; a pixel gets the id with the larger blended weight, 0 where accumulated opacity < 0.5.
/// Throws Error{kUsage} when the shape holds no Gaussian.
MaskSet selection_masks(const SelectionShape& shape, const GaussianCloud& cloud, const std::vector<Camera>& cameras);

/// Gaussians labelled object outside the shape grown by `margin` (fraction of its extent) become rest.
/// Returns how many.
size_t restrict_to_selection(const SelectionShape& shape, const GaussianCloud& cloud, Segmentation& segmentation,
                             float margin = 0.02f);

}  // namespace pliant
