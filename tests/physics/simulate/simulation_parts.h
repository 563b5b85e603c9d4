#pragma once

#include <cmath>

#include "physics/simulate/simulate.h"

namespace pliant::fixture {

inline SimulateOptions options_of(double fps, double duration) {
  SimulateOptions options;
  options.fps = fps;
  options.duration = duration;
  return options;
}

inline Interaction pin_below(double z, double duration = INFINITY) {
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.duration = duration;
  pin.region = Region::half_space(Vec3d(0, 0, z), Vec3d(0, 0, 1));
  return pin;
}

inline Interaction gust(const Vec3d& acceleration, double duration = INFINITY) {
  Interaction it;
  it.type = InteractionType::kGust;
  it.vector = acceleration;
  it.duration = duration;
  return it;
}

}  // namespace pliant::fixture
