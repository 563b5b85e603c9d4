#pragma once

#include <span>
#include <vector>

#include "fitting/objective/body_points.h"
#include "fitting/observe/markers.h"
#include "physics/simulate/simulate.h"

namespace pliant {

/// Where Kelvin-Voigt or mass-proportional damping takes energy from a motion; both are given as a time in seconds.
enum class DampingKind { kMassProportional, kKelvinVoigt };

struct MarkerModelOptions {
  SimulateOptions simulate;  ///< fps: of the states between which markers are interpolated; durations and damping of
                             ///< the body come from the parameters
  DampingKind damping = DampingKind::kMassProportional;
  double reach = 0.02;  ///< m; a marker farther than this from every particle is not on the body
};

struct MarkerParameters {
  double young_factor = 1;  ///< on E of all particles
  double damping_time = 0;  ///< s
  double release = 0;       ///< s of the recording, at which the simulation starts
};

/// Displacements [frames][K] m from rest, 1 / fps apart, from the release on.
struct MarkerMotion {
  double fps = 0;
  std::vector<std::vector<Vec3d>> displacement;

  double duration() const { return (static_cast<double>(displacement.size()) - 1) / fps; }
  /// By cubics through four states (Catmull and Rom 1974); zero before the release, the last one after the end.
  Vec3d at(double time, size_t marker) const;
};

/// A body with markers on it that moves from its release on under known loads.
class MarkerModel {
 public:
  /// rest [K, 3] m: where the markers sit on the body at rest; NaN = on nothing.
  MarkerModel(const MarkerModelOptions& options, const Particles& particles,
              const std::vector<Interaction>& interactions, std::span<const Vec3d> rest);

  /// Markers within reach of the body, ascending; all others stay out of the fit.
  const std::vector<int>& bound() const { return bound_; }
  /// m, distance of marker k from the nearest particle; infinite if it sits on nothing.
  double distance(size_t k) const { return distance_[k]; }

  /// Simulates `duration` seconds.  `substeps` per frame; 0 = chosen.  Throws Error{kNumerical} when it cannot be.
  MarkerMotion run(const MarkerParameters& parameters, double duration, int substeps = 0) const;
  /// Most substeps of a frame in the last run.
  int substeps() const { return substeps_; }

 private:
  MarkerModelOptions options_;
  Particles particles_;
  std::vector<Interaction> interactions_;
  std::vector<int> bound_;
  std::vector<double> distance_;
  std::vector<Vec3f> rest_;  // [bound]
  BodyPoints<float> points_;
  mutable int substeps_ = 0;
};

}  // namespace pliant
