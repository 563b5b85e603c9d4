#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "app/import/physgaussian_world.h"
#include "gaussians/base/error.h"
#include "physics/simulate/simulator.h"

namespace pliant {
namespace {

using Boundary = PhysGaussianConfig::Boundary;
using BoundaryType = PhysGaussianConfig::BoundaryType;

/// The change of velocity that a force on every particle of a box brings in PhysGaussian: its particles are the
/// Gaussians, each with an equal part of the volume of its cell.
Vec3d velocity_change(const PhysGaussianConfig& c, const Boundary& b, const std::vector<Vec3d>& gaussians) {
  const double dx = c.cell_size();
  std::map<std::tuple<int, int, int>, int> count;
  const auto cell = [&](const Vec3d& x) {
    return std::tuple(static_cast<int>(std::floor(x[0] / dx)), static_cast<int>(std::floor(x[1] / dx)),
                      static_cast<int>(std::floor(x[2] / dx)));
  };
  for (const Vec3d& x : gaussians) ++count[cell(x)];
  double touched = 0, mass = 0;
  for (const Vec3d& x : gaussians) {
    if (!in_physgaussian_box(x, b.point, b.half)) continue;
    double density = c.density;
    for (const auto& box : c.additional_material)
      if (in_physgaussian_box(x, box.point, box.half)) density = box.density;
    ++touched;
    mass += density * dx * dx * dx / count[cell(x)];
  }
  if (touched == 0)
    throw usage_error("boundary_conditions", "particle_impulse", "touches no Gaussian",
                      "move or enlarge its box (simulation space)");
  return b.force * c.substep_dt * b.num_dt * touched / mass;
}

/// Whether PhysGaussian sets velocities of nodes, after those of particles.
bool acts_on_nodes(const Boundary& b) {
  return b.type == BoundaryType::kCuboid || b.type == BoundaryType::kBoundingBox || b.type == BoundaryType::kSurface;
}

/// Whether two conditions set the velocity of the same particles, which are chosen by where they lie at rest.
bool same_part(const Boundary& a, const Boundary& b) {
  if (a.type != b.type || a.point != b.point) return false;
  if (a.type == BoundaryType::kTranslation) return a.half == b.half;
  return a.type == BoundaryType::kRotation && a.normal == b.normal && a.half_height == b.half_height &&
         a.radius == b.radius;
}

class WorldBuilder {
 public:
  WorldBuilder(const PhysGaussianConfig& config, Compatibility compatibility, const Particles& particles,
               const std::vector<Vec3d>& gaussians, PhysGaussianWorld& world)
      : c_(config),
        compat_(compatibility == Compatibility::kPhysGaussian),
        particles_(particles),
        gaussians_(gaussians),
        world_(world) {}

  void add(const Boundary& b) {
    switch (b.type) {
      case BoundaryType::kCuboid:
        cuboid(b);
        break;
      case BoundaryType::kImpulse:
        impulse(b);
        break;
      case BoundaryType::kBoundingBox:
        bounding_box(b);
        break;
      case BoundaryType::kTranslation:
        translation(b);
        break;
      case BoundaryType::kRotation:
        rotation(b);
        break;
      case BoundaryType::kSurface:
        surface(b);
        break;
      case BoundaryType::kReleaseSequentially:
        release(b);
        break;
    }
  }

 private:
  Interaction& push(InteractionType type, double start, double end) {
    Interaction it;
    it.type = type;
    it.start = start;
    it.duration = end - start;
    world_.interactions.push_back(it);
    return world_.interactions.back();
  }
  Interaction& push_collider(ContactKind contact, const Region& region, double start, double end) {
    Interaction& it = push(InteractionType::kCollider, start, end);
    it.contact = contact;
    it.region = region;
    return it;
  }
  void note(const std::string& text) {
    if (std::find(world_.notes.begin(), world_.notes.end(), text) == world_.notes.end()) world_.notes.push_back(text);
  }

  /// The whole grid stands still.
  void freeze(double start, double end) {
    push_collider(ContactKind::kSticky, Region::box(Vec3d::Constant(-c_.grid_lim), Vec3d::Constant(2 * c_.grid_lim)),
                  start, end);
  }

  void cuboid(const Boundary& b) {
    push_collider(ContactKind::kSticky, Region::box(b.point - b.half, b.point + b.half), b.start, b.end).vector =
        b.velocity;
    if (!b.reset) return;
    if (b.start > 0) {
      if (compat_) freeze(0, b.start);
      note(fmt::format("cuboid with reset: until start_time, {} s, {}", b.start,
                       compat_ ? "the whole grid is frozen, as in PhysGaussian"
                               : "PhysGaussian freezes the whole grid; here the body is free"));
    }
    if (b.end >= world_.options.duration) return;
    // At least one step, however long it is.
    const double step = 1 / (world_.options.fps * substeps_at_rest(world_.options, particles_));
    const double still = std::max(15 * c_.substep_dt, 1.01 * step);
    freeze(b.end, b.end + still);
    note(fmt::format("cuboid with reset: the whole body stands still for {:.3g} s after end_time, {} s", still, b.end));
  }

  void impulse(const Boundary& b) {
    double mass = 0;
    for (size_t i = 0; i < particles_.size(); ++i)
      if (in_physgaussian_box(particles_.position[i].cast<double>(), b.point, b.half)) mass += particles_.mass[i];
    if (!(mass > 0))
      throw usage_error("boundary_conditions", "particle_impulse", "touches no particle",
                        "move or enlarge its box (simulation space)");
    const Vec3d change = velocity_change(c_, b, gaussians_);
    const double seconds = b.num_dt * c_.substep_dt;
    Interaction& it = push(InteractionType::kPointForce, b.start, b.start + seconds);
    it.region = Region::box(b.point - b.half, b.point + b.half);
    it.vector = mass * change / seconds;
    note(
        fmt::format("particle_impulse: PhysGaussian's force acts on every particle; the same change of velocity, "
                    "{:.4g} m/s, is an impulse of {:.4g} N s here",
                    change.norm(), mass * change.norm()));
  }

  void bounding_box(const Boundary& b) {
    const Boundary always;
    const bool timed = b.start != always.start || b.end != always.end;
    if (timed)
      note(compat_ ? "bounding_box: start_time and end_time are ignored, as in PhysGaussian"
                   : "bounding_box: PhysGaussian ignores start_time and end_time; they are used here");
    const Boundary& times = compat_ ? always : b;
    const double wall = 3 * c_.cell_size();
    push_collider(ContactKind::kSeparating, Region::box(Vec3d::Constant(wall), Vec3d::Constant(c_.grid_lim - wall)),
                  times.start, times.end)
        .container = true;
  }

  /// How far earlier conditions have taken the same part, which is chosen by where it lies at rest.
  Vec3d way_before(const Boundary& b) const {
    Vec3d way = Vec3d::Zero();
    for (const Boundary& other : c_.boundaries) {
      if (!same_part(other, b) || other.start >= b.start) continue;
      const double time = std::min(other.end, b.start) - other.start;
      way += time * (b.type == BoundaryType::kRotation ? Vec3d(other.translation * other.normal) : other.velocity);
    }
    return way;
  }
  /// Whether a condition that begins later finds its part where it left it.
  bool held_until(const Boundary& b) const {
    return b.start == 0 || std::any_of(c_.boundaries.begin(), c_.boundaries.end(), [&](const Boundary& other) {
             return same_part(other, b) && other.start < b.start && other.end >= b.start;
           });
  }
  void note_nodes(const std::string& type, const Boundary& b) {
    note(
        "velocities that PhysGaussian prescribes for particles are prescribed for the grid nodes of that part: "
        "prescribed particles creep under load");
    if (!held_until(b))
      note(
          fmt::format("{} from {} s: PhysGaussian sets the velocity of the particles that lie in its region at the "
                      "beginning; here it is set of what lies there from then on",
                      type, b.start));
  }
  /// Whether a region holds some of the body at rest; PhysGaussian moves what it holds then, and nothing else.
  bool selects(const std::string& type, const Region& region) {
    const auto inside = [&](const auto& x) { return region.contains(x.template cast<double>()); };
    const bool some = std::any_of(particles_.position.begin(), particles_.position.end(), inside) ||
                      std::any_of(gaussians_.begin(), gaussians_.end(), inside);
    if (!some) {
      const Vec3d at = region.middle();
      note(fmt::format("{} at [{:.4g}, {:.4g}, {:.4g}] does nothing: no particle lies in its region at the beginning",
                       type, at.x(), at.y(), at.z()));
    }
    return some;
  }

  void translation(const Boundary& b) {
    const std::string type = "enforce_particle_translation";
    if (!selects(type, Region::box(b.point - b.half, b.point + b.half))) return;
    note_nodes(type, b);
    const Vec3d centre = b.point + way_before(b);
    push_collider(ContactKind::kSticky, Region::box(centre - b.half, centre + b.half), b.start, b.end).vector =
        b.velocity;
  }

  void rotation(const Boundary& b) {
    const std::string type = "enforce_particle_velocity_rotation";
    const Vec3d up = b.half_height * b.normal;
    if (!selects(type, Region::cylinder(b.point - up, b.point + up, b.radius))) return;
    note_nodes(type, b);
    const Vec3d centre = b.point + way_before(b);
    Interaction& it =
        push_collider(ContactKind::kSticky, Region::cylinder(centre - up, centre + up, b.radius), b.start, b.end);
    it.vector = b.translation * b.normal;
    it.angular_velocity = -b.rotation * b.normal;  // PhysGaussian's horizontal axes are left-handed about it
    it.pivot = centre;
  }

  void surface(const Boundary& b) {
    const ContactKind contact = compat_ || b.surface == "sticky" ? ContactKind::kSticky
                                : b.surface == "slip"            ? ContactKind::kSlip
                                                                 : ContactKind::kSeparating;
    push_collider(contact, Region::half_space(b.point, b.normal), b.start, b.end).friction = b.friction;
    if (compat_)
      note("surface_collider: every kind of surface is sticky, as in PhysGaussian");
    else if (b.surface != "sticky")
      note("surface_collider: PhysGaussian makes every surface sticky; '" + b.surface + "' is used here");
    if (contact == ContactKind::kSlip && b.friction > 0)
      note(fmt::format("surface_collider slip: its friction, {}, is not used; 'separate' has friction", b.friction));
    if (b.surface == "cut") note("surface_collider cut: PhysGaussian's fixed z limits .4 and .53 are not used");
  }

  void release(const Boundary& b) {
    note_nodes("release_particles_sequentially", b);
    const int layers = compat_ ? 50 : b.num_layers;
    if (b.num_layers != 50)
      note(fmt::format("release_particles_sequentially: {} layers {}", layers,
                       compat_ ? "as PhysGaussian overrides it" : "as written; PhysGaussian always takes 50"));
    int axis = 0;
    b.normal.cwiseAbs().maxCoeff(&axis);
    for (int k = 0; k < layers; ++k) {
      // Layer k and all between it and the end, on either side of it, are held until its time comes.
      const double end = b.end * (k + 1) / layers;
      const double half = std::abs(b.start_position - b.end_position) * (layers - k) / layers;
      if (!(end > b.start)) continue;
      Vec3d low = Vec3d::Constant(-4 * c_.grid_lim), high = -low;
      low[axis] = b.end_position - half;
      high[axis] = b.end_position + half;
      push_collider(ContactKind::kSticky, Region::box(low, high), b.start, end);
    }
  }

  const PhysGaussianConfig& c_;
  bool compat_;
  const Particles& particles_;
  const std::vector<Vec3d>& gaussians_;
  PhysGaussianWorld& world_;
};

}  // namespace

void add_physgaussian_boundaries(const PhysGaussianConfig& config, Compatibility compatibility,
                                 const Particles& particles, const std::vector<Vec3d>& gaussians,
                                 PhysGaussianWorld& world) {
  WorldBuilder builder(config, compatibility, particles, gaussians, world);
  // In the order in which PhysGaussian applies them: where they meet, the last one holds.
  for (const bool on_nodes : {false, true})
    for (const Boundary& b : config.boundaries)
      if (acts_on_nodes(b) == on_nodes) builder.add(b);
}

}  // namespace pliant
