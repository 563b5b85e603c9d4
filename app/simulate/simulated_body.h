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

/// The plane that the object rests on, as a floor that nothing passes: the support's plane that `extract` found, unless
/// a ground of the interactions that acts from the start is about that plane (normals within 30 degrees, at most 5 % of
/// the object's height below) or lies above it.
std::optional<Interaction> floor_of(const nlohmann::json& extract, const std::vector<Interaction>& interactions,
                                    const Scene& scene);

/// What acts on it and for how long.
struct SimulationPlan {
  SimulateOptions options;
  std::vector<Interaction> interactions;
  nlohmann::json script;  ///< rows of interactions.json
  nlohmann::json push;    ///< how the automatic push was sized, or null
  bool floor = false;     ///< the support's plane was added
};

constexpr double kPushStart = 0.3;  // s

/// From the stage's options: an interaction script, or one push from `push_start` [s] on that is sized to the
/// stiffness, or nothing where that is not given because the body moves already; pins, the support's floor.  Damping by
/// default only where a pin holds the body at the start.  A body that nothing holds or stops at the start does not
/// settle, and feels no gravity where no script is given.  `files`: object, for the push, and background, for an
/// obstacle; `extract`: height and contact that it found.
SimulationPlan plan_simulation(const Context& context, const InputFiles& files, const nlohmann::json& extract,
                               const Scene& scene, const SimulateStage& stage, const SimulatedBody& body,
                               std::optional<double> push_start = kPushStart);

/// From a configuration of PhysGaussian; moves `body` into its simulation space and gives it its material.
SimulationPlan plan_physgaussian(const Context& context, const InputFiles& files, const SimulateStage& stage,
                                 SimulatedBody& body);
/// What such a configuration says of the solid samples of a body that was planned by it; none where it is the same
/// everywhere.
std::optional<ElasticSamples> physgaussian_field(const SimulateStage& stage, const SimulatedBody& body);

}  // namespace pliant
