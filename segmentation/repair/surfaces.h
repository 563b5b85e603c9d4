#pragma once

#include <vector>

#include "segmentation/graph/contact.h"
#include "segmentation/repair/hole.h"

namespace pliant {

/// A plane of the surroundings, bounded by the convex hull of the Gaussians on it (scene units).
struct Surface {
  Plane plane;
  Vec3f u, v;               ///< axes in the plane; u, v, -normal is a right-handed frame
  std::vector<Vec2f> hull;  ///< corners in (u, v) about plane.point
  float margin = 0;         ///< how far beyond their centres' hull the Gaussians are opaque
  Vec2f coordinates(const Vec3f& x) const { return {u.dot(x - plane.point), v.dot(x - plane.point)}; }
  bool holds(const Vec3f& x) const;  ///< whether a point of the plane lies inside the hull grown by margin
};

/// Planes around a hole, found over all views.
struct Surfaces {
  std::vector<Surface> plane;
  float tolerance = 0;  ///< distance within which a point lies on a plane
};

/// Where hole pixels of one view lie.
struct HoleGeometry {
  std::vector<int> plane;    ///< [pixels] index into Surfaces::plane, -1 = no hole or no plane
  std::vector<Vec3f> point;  ///< [pixels] on that plane
  std::vector<int> nowhere;  ///< hole pixels of open parts that look past every surface
};

/// Fits at most `max_planes` planes to the points that the views see in a ring of `ring` pixels around their holes.
Surfaces find_surfaces(const std::vector<HoleView>& views, const Observation& observation,
                       const GaussianCloud& background, const std::vector<Camera>& cameras, int ring, int max_planes);

/// Puts every hole pixel of a view on the plane of the nearest ring pixel; where two planes of the ring form a corner
/// that opens to the camera (a table against a wall), on the nearer of the two along its ray.  Planes end at their
/// hulls; pixels nearest to something that is not flat stay without a plane, unless that stood in front of the object
/// and so says nothing about what is behind it.
HoleGeometry place_hole(const Surfaces& surfaces, const HoleView& view, const Observation& observation, size_t index,
                        const Camera& camera, int ring);

}  // namespace pliant
