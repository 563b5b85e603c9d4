#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "physics/loads/collider.h"

namespace pliant {

/// What a person or the world does to the body.
enum class InteractionType {
  kGravity,     ///< world gravity becomes `vector` [m/s^2] during the span
  kPin,         ///< grid nodes in `region` stand still during the span
  kPointForce,  ///< total force `vector` [N], spread evenly over the touched mass
  kImpulse,     ///< total impulse `vector` [N s] at `start`, spread evenly over the touched mass
  kGrab,        ///< damped spring between the centre of the touched mass and `path`
  kGust,        ///< drag rate * (vector - v) per kilogram towards wind velocity `vector` [m/s]; rate 0: `vector` is an
                ///< acceleration [m/s^2]
  kGround,      ///< nothing passes below the plane (region.point, region.vector = normal); Coulomb friction
  kCollider,    ///< obstacle of the shape `region` or `distance`, lying there at `start`; it moves along `path` or by
                ///< `vector` [m/s], and turns by `angular_velocity` about `pivot`
  kPoke,        ///< finger of radius region.radius whose centre follows `path`; separating, with friction
  kTorque,      ///< torque `vector` [N m] on the touched mass about its centre; along a line that all of this mass lies
                ///< on, it does nothing
  kWind,    ///< wind of velocity `vector` [m/s] on the surface: drag air_density / 2 * drag_coefficient * A |u| u of
            ///< each piece of area A (across the wind) that faces it, u the velocity of the air against the piece
  kWeight,  ///< a weight of `mass` hung on `region` from the beginning to the end: its inertia and its gravity
};

/// One row of an interaction script, in SI units and world axes.  The touched mass of a force, impulse, grab or gust
/// is the driving particles whose rest position lies in `region`.
struct Interaction {
  InteractionType type = InteractionType::kPointForce;
  double start = 0;                                           ///< s
  double duration = std::numeric_limits<double>::infinity();  ///< s
  Region region;
  Vec3d vector = Vec3d::Zero();

  /// Grab: where the centre of the touched mass is pulled; poke: where the finger is; collider: where `pivot` is.
  /// Times in s since `start`, ascending, linear in between, constant after the last.  A grab or finger without a
  /// duration ends with its path, unless that is a single point.
  struct PathPoint {
    double time;
    Vec3d position;
  };
  std::vector<PathPoint> path;
  double stiffness = 0;  ///< grab, N/m; 0 = (2 pi 10 Hz)^2 * mass of the body
  double damping = 0;    ///< grab, N s/m; 0 = critical for the mass of the body
  double max_force = 0;  ///< grab, N; 0 = what would stretch a bar of the touched material by half

  double rate = 0;                                 ///< gust, 1/s
  double drag_coefficient = 1, air_density = 1.2;  ///< wind; kg/m^3
  double mass = 0;                                 ///< weight, kg
  double friction = 0;  ///< ground, collider, poke: Coulomb coefficient; infinity = no sliding while pressed

  ContactKind contact = ContactKind::kSeparating;      ///< collider
  bool container = false;                              ///< collider: matter is inside the shape
  Vec3d angular_velocity = Vec3d::Zero();              ///< collider, rad/s
  Vec3d pivot = Vec3d::Zero();                         ///< collider, m, at `start`
  std::shared_ptr<const SignedDistanceGrid> distance;  ///< collider, instead of `region`

  double end() const { return start + duration; }
};

/// Name in interactions.json: gravity, pin, point_force, impulse, grab, gust, ground, collider, poke, torque,
/// wind, weight.
const char* interaction_name(InteractionType type);
/// All names, in the order of the enumeration.
std::vector<std::string> interaction_names();

/// Throws Error{kUsage} naming interaction `index` and its field: times finite and >= 0, vectors finite, a positive
/// radius, a cylinder with a length, a path with ascending times, a normal that is not zero, a collider with a shape, a
/// weight with a mass that hangs all the time.
void validate_interaction(const Interaction& interaction, size_t index);

/// Why nothing of an interaction falls into a clip of `seconds`, as a clause; empty where something does.
std::string why_idle(const Interaction& interaction, double seconds);

}  // namespace pliant
