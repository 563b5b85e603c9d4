#pragma once

#include "app/import/physgaussian_space.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// Whether PhysGaussian's known defects are repeated (--physgaussian-bugs) or put right.
enum class Compatibility { kCorrected, kPhysGaussian };

/// What a configuration becomes: everything in simulation space, where it is SI.
struct PhysGaussianWorld {
  SimulateOptions options;
  std::vector<Interaction> interactions;
  std::vector<std::string> notes;  ///< what differs from PhysGaussian, or what of it is repeated; a sentence each
};

/// Gives particles in simulation space the materials of the configuration: law, E, nu, density, boxes with their own.
void set_physgaussian_material(const PhysGaussianConfig& config, Compatibility compatibility, Particles& particles);

/// Adds to `world`, whose options are set, the interactions of the boundary conditions and what is to be said of them;
/// arguments as of physgaussian_world.
void add_physgaussian_boundaries(const PhysGaussianConfig& config, Compatibility compatibility,
                                 const Particles& particles, const std::vector<Vec3d>& gaussians,
                                 PhysGaussianWorld& world);

/// Boundary conditions, gravity, time and damping.  `gaussians` [G, 3] are the object's Gaussians in simulation space,
/// one particle each in PhysGaussian: an impulse there is a force on each of them, whose change of velocity is kept.
PhysGaussianWorld physgaussian_world(const PhysGaussianConfig& config, Compatibility compatibility,
                                     const Particles& particles, const std::vector<Vec3d>& gaussians);

}  // namespace pliant
