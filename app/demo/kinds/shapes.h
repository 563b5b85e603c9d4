#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

struct Ray {
  Vec3d origin, direction;  ///< direction is unit
};

constexpr double kNoHit = std::numeric_limits<double>::infinity();

/// Nearest crossing of a ray with a surface.
struct SurfaceHit {
  double t = kNoHit;
  Vec3d normal = Vec3d::Zero();  ///< unit, outward
};

/// A point of a surface with its outward unit normal.
struct SurfacePoint {
  Vec3d position, normal;
};

/// Triangles over shared vertices.
struct TriangleMesh {
  std::vector<Vec3d> vertex;
  std::vector<Vec3d> normal;  ///< outward unit normal per vertex
  std::vector<Eigen::Vector3i> triangle;
};

/// A surface with a direct ray intersection, in its own frame (metres).
class AnalyticShape {
 public:
  virtual ~AnalyticShape() = default;
  /// First crossing with t in (t_min, t_max).
  virtual SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const = 0;
  virtual bool inside(const Vec3d& x) const = 0;
  /// Points that cover the surface evenly, about `spacing` apart: rows that are staggered and jittered a little.
  virtual std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const = 0;
  /// A mesh with edges of about `spacing`; empty for shapes that never deform.
  virtual TriangleMesh mesh(double) const { return {}; }
  /// Ball that encloses the shape.
  virtual Vec3d bound_centre() const = 0;
  virtual double bound_radius() const = 0;
};

/// x^2/a^2 + y^2/b^2 + z^2/c^2 = 1.
std::unique_ptr<AnalyticShape> make_ellipsoid(const Vec3d& semi_axes);
/// |x| <= half.
std::unique_ptr<AnalyticShape> make_cuboid(const Vec3d& half);
/// Surface of revolution about z of the polyline (radius, z); to the right of its direction is outside.  It need not
/// be closed at the bottom; `inside` is the region below the outer part of the profile.
std::unique_ptr<AnalyticShape> make_lathe(const std::vector<Eigen::Vector2d>& profile);
/// The half x >= 0 of a torus around the y axis: a handle.
std::unique_ptr<AnalyticShape> make_handle(double ring_radius, double tube_radius);

}  // namespace pliant
