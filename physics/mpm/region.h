#pragma once

#include <Eigen/Core>

#include "gaussians/base/types.h"

namespace pliant {

/// A part of space: everything, a sphere, an axis-aligned box, or the half space behind a plane.
struct Region {
  enum class Kind { kAll, kSphere, kBox, kHalfSpace };

  Kind kind = Kind::kAll;
  Vec3d point = Vec3d::Zero();   ///< sphere: centre; box: low corner; half space: a point of the plane
  Vec3d vector = Vec3d::Zero();  ///< box: high corner; half space: unit normal, the region is (x - point) . normal <= 0
  double radius = 0;             ///< sphere

  static Region all() { return {}; }
  static Region sphere(const Vec3d& centre, double radius);
  static Region box(const Vec3d& low, const Vec3d& high);
  static Region half_space(const Vec3d& point, const Vec3d& normal);

  /// Distance to the surface, negative inside; -infinity for all.
  double signed_distance(const Vec3d& x) const;
  bool contains(const Vec3d& x) const { return signed_distance(x) <= 0; }
  /// The same region in another unit of length.
  Region scaled(double factor) const;
};

}  // namespace pliant
