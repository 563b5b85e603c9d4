#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/simulate/motion.h"
#include "app/simulate/simulated_body.h"
#include "gaussians/io/scene/scene.h"
#include "physics/simulate/push.h"

namespace pliant {

/// Where and along what a scene without interactions is pushed: the tip of the object, sideways as the clip's camera
/// sees it.  In metres.
struct PushPlace {
  Region region;
  Vec3d direction = Vec3d::UnitX();
};
PushPlace default_push_place(const Particles& particles, const ObjectTip& tip, const Vec3d& up,
                             const Vec3d& camera_right);

/// One row of interactions.json, in scene units.
nlohmann::json push_row(const PushPlace& place, double newtons, double start, double duration, double metres_per_unit);

/// The rows of interactions.json without a script: one sideways push at the tip from `start` [s] on, as strong as the
/// body's stiffness asks for when it is simulated with `simulate` and `held` by these pins, or as its inertia alone
/// asks for where neither they nor a floor hold it.  `object`: its splats; `extract`: height and contact that it found;
/// `push` receives how it was sized.  Throws Error{kInterrupted}.
nlohmann::json sized_push(const Context& context, const SimulateOptions& simulate, const std::filesystem::path& object,
                          const nlohmann::json& extract, const Scene& scene, const SimulateStage& stage,
                          const SimulatedBody& body, std::vector<Interaction> held, double start, nlohmann::json& push);

}  // namespace pliant
