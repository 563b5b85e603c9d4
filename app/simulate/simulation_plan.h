#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulated_body.h"
#include "physics/simulate/simulate.h"

namespace pliant {

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
