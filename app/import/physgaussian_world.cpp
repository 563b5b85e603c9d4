#include "app/import/physgaussian_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

using Boundary = PhysGaussianConfig::Boundary;
using BoundaryType = PhysGaussianConfig::BoundaryType;

bool in_box(const Vec3d& x, const Vec3d& centre, const Vec3d& half) {
  return ((x - centre).cwiseAbs().array() < half.array()).all();
}

/// Law and constants for a shear modulus mu.  PhysGaussian's yield stress bounds the Frobenius norm of the deviator,
/// ours is that of a uniaxial test, sqrt(3/2) times as much; its hardening adds 2 mu xi per unit of plastic strain in
/// that norm, which is 3 mu xi in a uniaxial test.
Material material_of(const PhysGaussianConfig& c, Compatibility compatibility, double mu) {
  Material m;
  const double uniaxial = std::sqrt(1.5) * c.yield_stress;
  if (c.material == "metal") {
    m.law = Law::kMetal;
    m.yield_stress = uniaxial;
    m.hardening = c.hardening ? 3 * mu * c.xi : 0;
  } else if (c.material == "sand") {
    m.law = Law::kSand;
    m.friction_angle = c.friction_angle;
  } else if (c.material == "foam") {
    m.law = Law::kFoam;
    m.yield_stress = c.yield_stress;
    m.plastic_viscosity = c.plastic_viscosity;
  } else if (c.material == "snow") {
    m.law = Law::kSnow;
  } else if (c.material == "plasticine") {
    m.law = Law::kPlasticine;
    m.yield_stress = uniaxial;
    m.hardening = compatibility == Compatibility::kCorrected ? -3 * mu * c.softening : -1.5 * c.softening;
  }
  m.as_physgaussian = compatibility == Compatibility::kPhysGaussian;
  return m;
}

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
    if (!in_box(x, b.point, b.half)) continue;
    double density = c.density;
    for (const auto& box : c.additional_material)
      if (in_box(x, box.point, box.half)) density = box.density;
    ++touched;
    mass += density * dx * dx * dx / count[cell(x)];
  }
  if (touched == 0)
    throw usage_error("boundary_conditions", "particle_impulse", "touches no Gaussian",
                      "move or enlarge its box (simulation space)");
  return b.force * c.substep_dt * b.num_dt * touched / mass;
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
  Interaction& push(InteractionType type, const Boundary& b) {
    Interaction it;
    it.type = type;
    it.start = b.start;
    it.duration = b.end - b.start;
    world_.interactions.push_back(it);
    return world_.interactions.back();
  }
  void note(const std::string& text) {
    if (std::find(world_.notes.begin(), world_.notes.end(), text) == world_.notes.end()) world_.notes.push_back(text);
  }

  void cuboid(const Boundary& b) {
    Interaction& it = push(InteractionType::kCollider, b);
    it.contact = ContactKind::kSticky;
    it.region = Region::box(b.point - b.half, b.point + b.half);
    it.vector = b.velocity;
    if (!b.reset) return;
    if (compat_) {
      // The whole grid stands still for 15 steps.
      Interaction& still = push(InteractionType::kCollider, b);
      still.contact = ContactKind::kSticky;
      still.start = b.end;
      still.duration = 15 * c_.substep_dt;
      still.region = Region::box(Vec3d::Zero(), Vec3d::Constant(c_.grid_lim));
      note("cuboid with reset: the whole grid is frozen for 15 steps after it, as in PhysGaussian");
    } else {
      note("cuboid with reset: PhysGaussian freezes the whole grid for 15 steps after it; here the body keeps moving");
    }
  }

  void impulse(const Boundary& b) {
    Boundary timed = b;
    timed.end = b.start + b.num_dt * c_.substep_dt;
    double mass = 0;
    for (size_t i = 0; i < particles_.size(); ++i)
      if (in_box(particles_.position[i].cast<double>(), b.point, b.half)) mass += particles_.mass[i];
    if (!(mass > 0))
      throw usage_error("boundary_conditions", "particle_impulse", "touches no particle",
                        "move or enlarge its box (simulation space)");
    const Vec3d change = velocity_change(c_, b, gaussians_);
    Interaction& it = push(InteractionType::kPointForce, timed);
    it.region = Region::box(b.point - b.half, b.point + b.half);
    it.vector = mass * change / (b.num_dt * c_.substep_dt);
    note(
        fmt::format("particle_impulse: PhysGaussian's force acts on every particle; the same change of velocity, "
                    "{:.4g} m/s, is an impulse of {:.4g} N s here",
                    change.norm(), mass * change.norm()));
  }

  void bounding_box(const Boundary& b) {
    const double wall = 3 * c_.cell_size();
    Interaction& it = push(InteractionType::kCollider, b);
    it.contact = ContactKind::kSeparating;
    it.container = true;
    it.region = Region::box(Vec3d::Constant(wall), Vec3d::Constant(c_.grid_lim - wall));
  }

  /// How far earlier conditions have taken the same part, which is chosen by where it lies at rest.
  Vec3d way_before(const Boundary& b) const {
    Vec3d way = Vec3d::Zero();
    for (const Boundary& other : c_.boundaries) {
      if (other.type != b.type || other.point != b.point || other.half != b.half || other.start >= b.start) continue;
      const double time = std::min(other.end, b.start) - other.start;
      way += time * (b.type == BoundaryType::kRotation ? Vec3d(other.translation * other.normal) : other.velocity);
    }
    return way;
  }
  void note_nodes() {
    note(
        "velocities that PhysGaussian prescribes for particles are prescribed for the grid nodes of that part: "
        "prescribed particles creep under load");
  }

  void translation(const Boundary& b) {
    note_nodes();
    Interaction& it = push(InteractionType::kCollider, b);
    const Vec3d centre = b.point + way_before(b);
    it.contact = ContactKind::kSticky;
    it.region = Region::box(centre - b.half, centre + b.half);
    it.vector = b.velocity;
  }

  void rotation(const Boundary& b) {
    note_nodes();
    Interaction& it = push(InteractionType::kCollider, b);
    const Vec3d centre = b.point + way_before(b);
    it.contact = ContactKind::kSticky;
    it.region = Region::cylinder(centre - b.half_height * b.normal, centre + b.half_height * b.normal, b.radius);
    it.vector = b.translation * b.normal;
    it.angular_velocity = -b.rotation * b.normal;  // PhysGaussian's horizontal axes are left-handed about it
    it.pivot = centre;
  }

  void surface(const Boundary& b) {
    Interaction& it = push(InteractionType::kCollider, b);
    it.region = Region::half_space(b.point, b.normal);
    it.friction = b.friction;
    it.contact = b.surface == "sticky" ? ContactKind::kSticky
                 : b.surface == "slip" ? ContactKind::kSlip
                                       : ContactKind::kSeparating;
    if (compat_) {
      it.contact = ContactKind::kSticky;
      note("surface_collider: every kind of surface is sticky, as in PhysGaussian");
    } else if (b.surface != "sticky") {
      note("surface_collider: PhysGaussian makes every surface sticky; '" + b.surface + "' is used here");
    }
    if (b.surface == "cut") note("surface_collider cut: PhysGaussian's fixed z limits .4 and .53 are not used");
  }

  void release(const Boundary& b) {
    const int layers = compat_ ? 50 : b.num_layers;
    if (b.num_layers != 50)
      note(fmt::format("release_particles_sequentially: {} layers {}", layers,
                       compat_ ? "as PhysGaussian overrides it" : "as written; PhysGaussian always takes 50"));
    for (int k = 0; k < layers; ++k) {
      // Layer k and all between it and the end, on either side of it, are held until its time comes.
      Boundary timed = b;
      timed.end = b.end * (k + 1) / layers;
      const double half = std::abs(b.start_position - b.end_position) * (layers - k) / layers;
      if (!(timed.end > timed.start && half > 0)) continue;
      Interaction& it = push(InteractionType::kCollider, timed);
      it.contact = ContactKind::kSticky;
      it.region =
          Region::cylinder((b.end_position - half) * b.normal, (b.end_position + half) * b.normal, 4 * c_.grid_lim);
    }
  }

  const PhysGaussianConfig& c_;
  bool compat_;
  const Particles& particles_;
  const std::vector<Vec3d>& gaussians_;
  PhysGaussianWorld& world_;
};

}  // namespace

void set_physgaussian_material(const PhysGaussianConfig& config, Compatibility compatibility, Particles& particles) {
  particles.materials.clear();
  particles.material_index.clear();
  std::map<double, uint16_t> index_of_shear;
  for (size_t i = 0; i < particles.size(); ++i) {
    double young = config.young, poisson = config.poisson, density = config.density;
    for (const auto& box : config.additional_material)
      if (in_box(particles.position[i].cast<double>(), box.point, box.half)) {
        young = box.young;
        poisson = box.poisson;
        density = box.density;
      }
    particles.young[i] = static_cast<float>(young);
    particles.poisson[i] = static_cast<float>(poisson);
    particles.mass[i] = static_cast<float>(density) * particles.volume[i];
    const double mu = lame(young, poisson).mu;
    const auto [at, added] = index_of_shear.try_emplace(mu, static_cast<uint16_t>(index_of_shear.size()));
    if (added) particles.materials.push_back(material_of(config, compatibility, mu));
    particles.material_index.push_back(at->second);
  }
}

PhysGaussianWorld physgaussian_world(const PhysGaussianConfig& config, Compatibility compatibility,
                                     const Particles& particles, const std::vector<Vec3d>& gaussians) {
  PhysGaussianWorld world;
  world.notes = config.notes;
  const bool compat = compatibility == Compatibility::kPhysGaussian;
  world.options.fps = 1 / config.frame_dt;
  world.options.duration = config.frame_num * config.frame_dt;
  world.options.gravity = config.gravity;
  world.options.pic = config.rpic_damping < -0.001;
  // Factors per substep, as rates of decay in seconds.
  if (config.rpic_damping > 0)
    world.options.strain_rate_damping = -std::log(1 - config.rpic_damping) / config.substep_dt;
  if (config.grid_v_damping_scale < 1)
    world.options.damping_time = -2 * config.substep_dt / std::log(config.grid_v_damping_scale);
  double fastest = 0;
  for (size_t i = 0; i < particles.size(); ++i)
    fastest = std::max(fastest, sound_speed(particles.material(i), particles.young[i], particles.poisson[i],
                                            particles.mass[i] / particles.volume[i]));
  const double courant = fastest * config.substep_dt / config.cell_size();
  if (compat) {
    world.options.substeps = std::max(1, static_cast<int>(config.frame_dt / config.substep_dt));
    world.options.courant_cap = 1;
    world.notes.push_back(
        fmt::format("substep_dt {:.3g} s is kept (Courant number {:.2g}); a frame that becomes unstable is repeated "
                    "with half of it",
                    config.substep_dt, courant));
  } else {
    world.notes.push_back(
        fmt::format("substep_dt {:.3g} s (Courant number {:.2g}) is replaced by one for Courant number {}",
                    config.substep_dt, courant, world.options.courant));
  }
  if (compat && (config.material == "metal" || config.material == "foam"))
    world.notes.push_back("the principal stress of " + config.material +
                          " is multiplied by the stretch, as in PhysGaussian");
  if (config.material == "snow")
    world.notes.push_back(compat ? "snow has no stress, as in PhysGaussian: particles fly freely"
                                 : "snow is that of Stomakhin et al. (2013); PhysGaussian's has no stress");
  if (config.material == "plasticine")
    world.notes.push_back(compat ? "softening subtracts a strain from a stress, as in PhysGaussian, and hardly acts"
                                 : "softening lowers the yield stress by 2 mu softening per unit of plastic strain; "
                                   "PhysGaussian subtracts the bare strain");
  // What is read, so that mistakes are found, and decided otherwise here.
  if (config.filling)
    world.notes.push_back("particle_filling is not used: `seed` fills the object inside its surface (--particles)");
  if (!config.view_keys.empty()) {
    std::string keys;
    for (const std::string& key : config.view_keys) keys += (keys.empty() ? "" : ", ") + key;
    world.notes.push_back(keys + ": not used; the clip's camera is that of --camera or --cameras");
  }
  WorldBuilder builder(config, compatibility, particles, gaussians, world);
  for (const Boundary& b : config.boundaries) builder.add(b);
  return world;
}

}  // namespace pliant
