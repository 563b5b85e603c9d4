#pragma once

#include <memory>
#include <optional>

#include "fitting/fields/field.h"
#include "fitting/modal/modal_search.h"
#include "fitting/solve/gauss_newton.h"

namespace pliant {

struct VibrationFitOptions {
  SimulateOptions simulate;  ///< of the roll-outs; fps, duration, substeps and damping_time are the fit's
  ModesOptions modes;
  std::optional<VibrationModes> known_modes;  ///< of the particles as they are given; none = found
  ModalSearchOptions search;
  GaussNewtonOptions refine;  ///< iterations and tolerance
  int candidates = 3;         ///< minima of the search that are refined
  int most_modes = 6;         ///< whose amplitudes are refined
  int most_smooth = 8;        ///< velocities along each axis, instead of modes, when the motion begins at rest
  double most_periods = 8;    ///< of the strongest mode of the search's best, that all roll-outs are compared over
  double noise = 0;           ///< of the tracks, in their unit; 0 = what remains
  std::shared_ptr<const Field>
      field;                       ///< ln of a further factor of E at the particles, with few parameters; null = none
  std::function<bool()> stop;      ///< asked before every roll-out; true ends the fit with Error{kInterrupted}
  double field_sigma = 1;          ///< standard deviation that is expected of each of its parameters, about 0
  double field_limit = INFINITY;   ///< of each of them, either way
  double factor_sigma = INFINITY;  ///< and of ln of the common factor of E, about what the search finds
};

/// What tracks say of a body whose Young's moduli are off by one factor, or by a field of factors.
struct VibrationFit {
  double log10_factor = 0, log10_sigma = 0;  ///< of all E; one standard deviation of the mean of log10 E
  std::vector<double> field;                 ///< parameters of the field of further factors; empty without one
  std::vector<double> young_sigma;           ///< [N] decades, standard deviation of log10 E of each particle
  double damping_time = 0, damping_time_low = 0, damping_time_high = 0;  ///< s; within one standard deviation
  double time = 0;                 ///< s on the tracks' clock, at which the roll-out starts
  int first_frame = 0;             ///< of the tracks, that was compared
  SimulationState start;           ///< of the particles with the factor applied
  int last_frame = 0;              ///< of the tracks, that was compared
  int subframes = 1;               ///< frames of the roll-out for one of the tracks
  int substeps = 0;                ///< of one of its frames
  double rms_search = 0, rms = 0;  ///< of tracks against roll-outs: from the best candidate of the search, and refined,
                                   ///< over the frames compared
  double rms_rest = 0;             ///< if nothing moved, over these frames
  VibrationModes modes;
  ModalSearch search;
  std::vector<double> candidate_factor, candidate_rms;  ///< the minima that were refined: log10 factor and rms after it
  GaussNewtonSummary
      summary;  ///< of the refinement; of a field's, over all rounds, its loss as squares of the tracks' unit
  double seconds = 0, seconds_search = 0;  ///< the whole, and of it the modes and the search

  /// The particles with the fitted E; `field` as in the options.
  Particles fitted(const Particles& particles, const Field* field = nullptr) const;
  /// Frame of the roll-out that shows frame f of the tracks.
  int rollout_frame(int f, double fps) const;
};

/// How far a fit is: it goes on from here, and ends as if it had not been interrupted.
struct VibrationFitState {
  std::optional<VibrationModes> modes;        ///< none: not found yet
  std::vector<GaussNewtonState> refinements;  ///< in the order in which they are made; all but the last are finished
};

/// Called when the modes are found and in every iteration of Gauss-Newton.  What it throws ends the fit.
using VibrationFitSink = std::function<void(const VibrationFitState&)>;

/// Vibration modes; the search over log E; then Gauss-Newton on roll-outs of log E (and of the field's parameters),
/// damping and the start: amplitudes of the strongest modes, or, when the motion begins with frame 0 and that shows the
/// shape at rest, a smooth velocity.  A field is refined over the first few frames, then over twice as many, up to all.
/// `progress` gets a line for every stage.  What `state` holds of an earlier call of the same options and inputs is not
/// done again.
VibrationFit fit_vibration(const VibrationFitOptions& options, const Particles& particles,
                           const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                           const std::function<void(const std::string&)>& progress = {}, VibrationFitState state = {},
                           const VibrationFitSink& sink = {});

}  // namespace pliant
