#pragma once

#include <cstdint>
#include <vector>

#include "physics/mpm/region.h"

namespace pliant {

/// Acceleration a - drag * v of the particles whose load bits contain `bit`.
template <class T>
struct BodyLoad {
  uint32_t bit = 0;
  Vec3<T> acceleration = Vec3<T>::Zero();  ///< m/s^2
  T drag = 0;                              ///< 1/s
};

/// Plane that nodes at or below it do not pass: (x - point) . normal <= 0.
struct GroundPlane {
  Vec3d point, normal;
  double friction = 0;
};

/// What acts during one substep.
template <class T>
struct StepLoads {
  Vec3<T> gravity = Vec3<T>::Zero();  ///< m/s^2, on every node
  T velocity_scale = 1;               ///< exp(-2 dt / damping time)
  T viscosity_time = 0;               ///< s, Kelvin-Voigt
  std::vector<BodyLoad<T>> body;
  std::vector<Region> pins;
  std::vector<GroundPlane> grounds;
};

}  // namespace pliant
