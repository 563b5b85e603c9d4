#include "app/import/physgaussian_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace pliant {
namespace {

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

}  // namespace

void set_physgaussian_material(const PhysGaussianConfig& config, Compatibility compatibility, Particles& particles) {
  particles.materials.clear();
  particles.material_index.clear();
  std::map<double, uint16_t> index_of_shear;
  for (size_t i = 0; i < particles.size(); ++i) {
    double young = config.young, poisson = config.poisson, density = config.density;
    for (const auto& box : config.additional_material)
      if (in_physgaussian_box(particles.position[i].cast<double>(), box.point, box.half)) {
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
  add_physgaussian_boundaries(config, compatibility, particles, gaussians, world);
  return world;
}

}  // namespace pliant
