#pragma once

#include "fitting/fit/fit_vibration.h"
#include "fitting/modal/start_shapes.h"

namespace pliant {

/// `particles` with E times exp(common + field); without a field null.
Particles with_factors(const Particles& particles, const Field* field, double common,
                       std::span<const double> parameters);

/// Roll-outs as a function of (ln factor of E, ln damping rate, the field's parameters, displacements, velocities of
/// some shapes); without displacements when the motion begins at rest.  What it is made of must outlive it.
class VibrationRollouts {
 public:
  VibrationRollouts(const VibrationFitOptions& options, const Particles& particles,
                    const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                    const VibrationModes& modes, const ModalSearch& search, const ModalMotion& motion);

  static constexpr double kMargin = 0.4;  ///< of the first steps
  /// The time step of all roll-outs from now on: the one that a simulation chooses for E times exp(margin).
  void fix_time_step(std::vector<double> p, double margin);

  /// Frames of the tracks up to this one are compared from now on.
  void compare_until(int frame);

  const std::vector<double>& start() const { return start_; }  ///< what the search found, as parameters
  double time() const { return time_; }
  int subframes() const { return subframes_; }
  int first_frame() const { return first_; }
  int last_frame() const { return last_; }
  int substeps() const { return simulate_.substeps; }
  /// Of all parameters, those of the field.
  std::span<const double> field_of(std::span<const double> p) const { return p.subspan(2, field_size_); }

  SimulationState state_of(std::span<const double> p) const;
  Particles particles_of(std::span<const double> p) const;

  /// Errors of all tracks over `noise`, without the share of each point's that stays (staying_errors.h).
  std::vector<double> residuals(std::span<const double> p, double noise) const;
  /// From what `result` leaves: how much of a point's errors stays.  `result` and later residuals are without it.
  void find_staying(GaussNewtonResult& result);
  /// Of the tracks in the frames compared; 0 where nothing was followed.
  double weight() const;
  /// Of the tracks, with what stays, in their unit.
  double rms(std::span<const double> p) const;

  /// `options` with the bounds, steps and priors of the parameters; `field_spread`: of the spread that is expected of
  /// the field's.
  GaussNewtonOptions bounded(GaussNewtonOptions options, double field_spread = 1) const;

 private:
  std::vector<double> errors_of(std::span<const double> p, double noise) const;
  size_t columns() const { return tracks_.tracks().rest.size() * static_cast<size_t>(tracks_.tracks().axes()); }
  std::vector<double> largest_steps() const;

  const Particles& particles_;
  const std::vector<Interaction>& interactions_;
  const TrackLoss<float>& tracks_;
  int first_ = 0, last_ = 0, lead_ = 0, subframes_ = 1;
  double time_ = 0, staying_ = 0;
  SimulateOptions simulate_;
  bool at_rest_ = false;  // at the start
  std::function<bool()> stop_;
  const Field* field_ = nullptr;  // of further factors
  size_t field_size_ = 0;
  std::vector<double> field_step_;  // of its parameters, at most, in an iteration
  double field_sigma_ = 1, field_limit_ = INFINITY, factor_sigma_ = INFINITY;
  StartShapes shapes_;  // whose amplitudes are parameters
  std::vector<double> start_;
};

}  // namespace pliant
