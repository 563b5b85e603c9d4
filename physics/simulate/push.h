#pragma once

#include <functional>
#include <optional>
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
  /// Of the touched mass: what moves farthest of it and does not count, such as a petal that flaps; none = the
  /// farthest of the whole body counts.
  std::optional<double> loose_share;
  int trials = 3;  ///< of the trial body, at most, where one of them comes near; else up to 10
  /// The load found on the trial body is tried on the body itself and scaled by what it does there, twice where that
  /// is far from what is wanted; not for a body that would have to settle or to find its rest shape first.
  bool scale_on_body = false;
  std::function<bool(double)> go_on;  ///< told the share of the work that is done; false ends it with
                                      ///< Error{kInterrupted}
};

struct PushSize {
  double newtons = 0;
  double peak_fraction = 0;  ///< as in LoadSize
  int trials = 0;
};

/// How long the vector of a load must be.
struct LoadSize {
  double length = 0;         ///< in the units of its vector
  double peak_fraction = 0;  ///< of the trial that was chosen; the wanted one, where it was scaled to it
  int trials = 0;
};
/// Length of `load`'s vector with which it moves the body by `fraction` of its height at most, found by short trials of
/// the dynamics themselves on a body of `max_particles`: a small load first, then a search for the root of log peak
/// over log length, by halves where they jump, as where friction holds.  Its vector gives the direction. `interactions`
/// are the pins and the ground of the real run. Throws Error{kUsage} when it touches nothing.
LoadSize size_load(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Interaction& load);

/// size_load() of a force on `region` along `direction` from the start.
PushSize size_push(const PushOptions& options, const Particles& particles, const std::vector<Interaction>& interactions,
                   const Region& region, const Vec3d& direction);

}  // namespace pliant
