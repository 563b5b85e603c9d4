#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/simulate/motion.h"
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

}  // namespace pliant
