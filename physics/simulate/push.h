#pragma once

#include <vector>

#include "physics/simulate/simulate.h"

namespace pliant {

struct PushOptions {
  SimulateOptions simulate;  ///< damping, gravity and settling of the real run
  Vec3d up = {0, 0, 1};      ///< the body's height is its extent along this unit vector, m
  double height = 0;         ///< m; 0 = extent of the particles along `up`
  double fraction = 0.15;    ///< wanted peak displacement from the first frame / height
  double duration = 0.5;     ///< s for which the push lasts
  int max_particles = 2000;  ///< of the trial body
  int trials = 3;            ///< at most
};

struct PushSize {
  double newtons = 0;
  double peak_fraction = 0;  ///< reached by the last trial
  int trials = 0;
};

/// How long the vector of a load must be.
struct LoadSize {
  double length = 0;         ///< in the units of its vector
  double peak_fraction = 0;  ///< reached by the last trial
  int trials = 0;
};
/// Length of `load`'s vector with which it moves the body by `fraction` of its height at most, found by short trials of
/// the dynamics themselves: a small load first, then corrections for what is not linear.  Its vector gives the
/// direction.  `interactions` are the pins and the ground of the real run.  Throws Error{kUsage} when it touches
/// nothing.
LoadSize size_load(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Interaction& load);

/// size_load() of a force on `region` along `direction` from the start.
PushSize size_push(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Region& region, const Vec3d& direction);

}  // namespace pliant
