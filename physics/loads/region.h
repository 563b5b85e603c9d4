#pragma once

#include <Eigen/Core>

#include "gaussians/base/types.h"

namespace pliant {

/// A part of space: everything, a sphere, an axis-aligned box, the half space behind a plane, or a capped cylinder.
struct Region {
  enum class Kind { kAll, kSphere, kBox, kHalfSpace, kCylinder };

  Kind kind = Kind::kAll;
  Vec3d point = Vec3d::Zero();   ///< sphere: centre; box: low corner; half space: a point of the plane; cylinder: the
                                 ///< middle of one cap
  Vec3d vector = Vec3d::Zero();  ///< box: high corner; half space: unit normal, the region is (x - point) . normal <=
                                 ///< 0; cylinder: the middle of the other cap
  double radius = 0;             ///< sphere, cylinder

  static Region all() { return {}; }
  static Region sphere(const Vec3d& centre, double radius);
  static Region box(const Vec3d& low, const Vec3d& high);
  static Region half_space(const Vec3d& point, const Vec3d& normal);
  static Region cylinder(const Vec3d& end, const Vec3d& other_end, double radius);

  /// Distance to the surface, negative inside; -infinity for all.
  double signed_distance(const Vec3d& x) const;
  /// Unit gradient of the signed distance: the outward normal at the nearest point of the surface.
  Vec3d normal(const Vec3d& x) const;
  /// Derivative of a scalar by x from that by the normal there [1/m]; 0 where the normal turns at once.
  Vec3d normal_adjoint(const Vec3d& x, const Vec3d& adj_normal) const;
  bool contains(const Vec3d& x) const { return signed_distance(x) <= 0; }
  /// Middle of a bounded region: not of all or a half space.
  Vec3d middle() const { return kind == Kind::kSphere ? point : Vec3d(0.5 * (point + vector)); }
  bool bounded() const { return kind != Kind::kAll && kind != Kind::kHalfSpace; }
  /// Half of its smallest extent; infinity where it is not bounded.
  double half_thickness() const;
  /// Distance from x within which all of it lies; infinity where it is not bounded.
  double farthest(const Vec3d& x) const;
  /// The region whose surface lies `distance` outside of this one's (inside where negative, by less than half of a
  /// cylinder's height).
  Region grown(double distance) const;
  /// The same region in another unit of length.
  Region scaled(double factor) const;
};

}  // namespace pliant
