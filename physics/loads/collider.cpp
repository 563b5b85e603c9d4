#include "physics/loads/collider.h"

#include <algorithm>
#include <cmath>

namespace pliant {

void Collider::move(const Vec3d& pivot_at_start, const Vec3d& way, double elapsed) {
  const double angle = angular_velocity.norm() * elapsed;
  rotation =
      angle != 0 ? Eigen::AngleAxisd(angle, angular_velocity.normalized()).toRotationMatrix() : Mat3d::Identity();
  pivot = pivot_at_start + way;
  translation = pivot - rotation * pivot_at_start;
}

SignedDistanceGrid::Sample Collider::surface(const Vec3d& x) const {
  const Vec3d own = rotation.transpose() * (x - translation);
  SignedDistanceGrid::Sample s =
      grid ? grid->sample(own) : SignedDistanceGrid::Sample{shape.signed_distance(own), shape.normal(own)};
  s.normal = rotation * s.normal;
  if (container) {
    s.distance = -s.distance;
    s.normal = -s.normal;
  }
  return s;
}

Vec3d Collider::surface_adjoint(const Vec3d& x, const Vec3d& adj_normal, const Vec3d& adj_velocity) const {
  const Vec3d own = rotation.transpose() * (x - translation);
  const Vec3d adj = (container ? -1.0 : 1.0) * (rotation.transpose() * adj_normal);
  const Vec3d by_own = grid ? grid->normal_adjoint(own, adj) : shape.normal_adjoint(own, adj);
  return rotation * by_own + adj_velocity.cross(angular_velocity);
}

namespace {

/// What is left of the sliding velocity, 0 .. 1, when friction takes mu times the approach from it.
double kept_by_friction(double friction, double approach, double sliding) {
  return sliding > 0 ? std::max(0.0, 1 - friction * approach / sliding) : 0.0;
}

}  // namespace

Vec3d velocity_after_contact(const Collider& collider, const Vec3d& normal, const Vec3d& w, const Vec3d& v) {
  if (collider.kind == ContactKind::kSticky) return w;
  const Vec3d u = v - w;
  const double approach = -u.dot(normal);
  if (collider.kind == ContactKind::kSlip) return w + u + approach * normal;
  if (!(approach > 0)) return v;
  const Vec3d t = u + approach * normal;
  return w + kept_by_friction(collider.friction, approach, t.norm()) * t;
}

SurfaceContactGradient velocity_after_contact_adjoint(const Collider& collider, const Vec3d& normal, const Vec3d& w,
                                                      const Vec3d& v, const Vec3d& adj_after) {
  SurfaceContactGradient by;
  const Vec3d u = v - w;
  const double approach = -u.dot(normal);
  // Of t = u - (u . n) n.
  const auto add_tangential = [&](const Vec3d& adj_t) {
    by.v += adj_t - adj_t.dot(normal) * normal;
    by.normal += approach * adj_t - adj_t.dot(normal) * u;
  };
  if (collider.kind == ContactKind::kSlip) {
    add_tangential(adj_after);
  } else if (collider.kind == ContactKind::kSeparating) {
    if (!(approach > 0)) {
      by.v = adj_after;
      return by;
    }
    const Vec3d t = u + approach * normal;
    const double sliding = t.norm(), kept = kept_by_friction(collider.friction, approach, sliding);
    if (kept > 0) {
      // u' = t - mu a t / |t| with a = -u . n.
      const Vec3d along = t / sliding;
      const double adj_along = adj_after.dot(along), mu_a = collider.friction * approach / sliding;
      add_tangential(kept * adj_after + mu_a * adj_along * along);
      by.v += collider.friction * adj_along * normal;
      by.normal += collider.friction * adj_along * u;
    }
  }
  by.w = adj_after - by.v;
  return by;
}

}  // namespace pliant
