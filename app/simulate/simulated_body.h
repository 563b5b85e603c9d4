#pragma once

#include <optional>

#include "app/import/physgaussian_world.h"
#include "app/simulate/motion.h"
#include "app/simulate/simulate_stage.h"
#include "app/store/particles.h"
#include "physics/body/make_particles.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// The object as the solver takes it.
struct SimulatedBody {
  ParticleFile file;
  SolidSamples samples;  ///< simulated ones, scene units
  DrivingParticles drivers;
  Particles particles;  ///< SI, in `space`
  SimulationSpace space;
};

/// That of --solver.
GridKind grid_kind(const std::string& solver);

/// The homogeneous material at every solid sample.
ElasticSamples solid_material(const ParticleFile& file, const ObjectMaterial& material);

/// The particles that `solid`, the material of all solid samples, gives.
SimulatedBody make_body(ParticleFile file, const Scene& scene, const ElasticSamples& solid, const Material& material);

/// What `seed` says holds the object, in metres; `pinned_json` is that of solid.h5 or particles.h5.
std::vector<Interaction> pins_of(const std::string& pinned_json, const Scene& scene);

/// Its tip, given what `seed` says holds it.
ObjectTip tip_of(const SimulatedBody& body, const Scene& scene);

}  // namespace pliant
