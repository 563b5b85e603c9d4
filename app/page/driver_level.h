#pragma once

#include "app/page/coded_motion.h"
#include "app/simulate/moving_scene.h"
#include "gaussians/base/binding.h"

namespace pliant {

/// A body of fewer driving particles for the same object.
struct DriverLevel {
  std::vector<Vec3f> rest;  ///< [M, 3] scene units
  Binding binding;          ///< of the object's Gaussians to them
  bool full = false;        ///< the driving particles that were simulated
};

/// The simulated particles themselves, or `count` of them clustered anew from the solid samples.
DriverLevel driver_level(const MovingScene& moving, const Scene& scene, int count);

/// What the simulated particles of a frame do to those of a level: each is carried by its neighbours at rest.
std::vector<DriverFrame> motion_of(const MovingScene& moving, const DriverLevel& level);

}  // namespace pliant
