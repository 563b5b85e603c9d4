#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>

#include "physics/loads/region.h"
#include "physics/loads/signed_distance_grid.h"

namespace pliant {

/// How matter moves at the surface of a collider.
enum class ContactKind : uint8_t {
  kSticky,      ///< with the surface, in both directions
  kSlip,        ///< along the surface; neither into it nor away from it
  kSeparating,  ///< not into it; Coulomb friction along it while pressed against it
};

/// A rigid obstacle as it is during one substep.
struct Collider {
  ContactKind kind = ContactKind::kSeparating;
  double friction = 0;  ///< Coulomb coefficient of a separating surface; infinity: no sliding while pressed
  Region shape;         ///< solid, in its own frame [m]
  std::shared_ptr<const SignedDistanceGrid> grid;  ///< solid instead of `shape`, when given
  bool container = false;                          ///< the solid is what lies outside the shape

  Mat3d rotation = Mat3d::Identity();      ///< world from own frame
  Vec3d translation = Vec3d::Zero();       ///< m, world from own frame
  Vec3d velocity = Vec3d::Zero();          ///< m/s, of the point `pivot`
  Vec3d angular_velocity = Vec3d::Zero();  ///< rad/s
  Vec3d pivot = Vec3d::Zero();             ///< m, world

  /// Places the shape where it is `elapsed` seconds after it lay in its own frame: turned about `pivot_at_start` by
  /// the angular velocity and moved by `way` [m].
  void move(const Vec3d& pivot_at_start, const Vec3d& way, double elapsed);

  /// Signed distance [m] from the surface, negative in the solid, and the normal that points out of the solid.
  SignedDistanceGrid::Sample surface(const Vec3d& x) const;
  /// Derivative of a scalar by x from those by the normal there and by the velocity of the rigid body there.
  Vec3d surface_adjoint(const Vec3d& x, const Vec3d& adj_normal, const Vec3d& adj_velocity) const;
  /// Velocity [m/s] of the rigid body at x.
  Vec3d velocity_at(const Vec3d& x) const { return velocity + angular_velocity.cross(x - pivot); }
};

/// Velocity after contact with a surface of normal n that moves with velocity w: with u = v - w
///   sticky u' = 0; slip u' = u - (u . n) n; separating, if u . n < 0, u' = t max(0, 1 + mu (u . n) / |t|) with
///   t = u - (u . n) n (Stomakhin et al. 2013, eq. 12).
Vec3d velocity_after_contact(const Collider& collider, const Vec3d& normal, const Vec3d& w, const Vec3d& v);
/// Derivatives of a scalar with respect to v, n and w, from that with respect to the velocity after contact.
struct SurfaceContactGradient {
  Vec3d v = Vec3d::Zero(), normal = Vec3d::Zero(), w = Vec3d::Zero();
};
SurfaceContactGradient velocity_after_contact_adjoint(const Collider& collider, const Vec3d& normal, const Vec3d& w,
                                                      const Vec3d& v, const Vec3d& adj_after);

}  // namespace pliant
