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

Vec3d velocity_after_contact_adjoint(const Collider& collider, const Vec3d& normal, const Vec3d& w, const Vec3d& v,
                                     const Vec3d& adj_after) {
  if (collider.kind == ContactKind::kSticky) return Vec3d::Zero();
  const auto along_surface = [&](const Vec3d& a) -> Vec3d { return a - a.dot(normal) * normal; };
  if (collider.kind == ContactKind::kSlip) return along_surface(adj_after);
  const Vec3d u = v - w;
  const double approach = -u.dot(normal);
  if (!(approach > 0)) return adj_after;
  const Vec3d t = u + approach * normal;
  const double sliding = t.norm(), kept = kept_by_friction(collider.friction, approach, sliding);
  if (!(kept > 0)) return Vec3d::Zero();
  // u' = t - mu a t / |t| with a = -u . n.
  const Vec3d along = t / sliding, adj = along_surface(adj_after);
  const double adj_along = adj.dot(along), mu_a = collider.friction * approach / sliding;
  return kept * adj + mu_a * adj_along * along + collider.friction * adj_along * normal;
}

}  // namespace pliant
