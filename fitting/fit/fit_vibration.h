#pragma once

#include "fitting/fit/gauss_newton.h"
#include "fitting/fit/modal_search.h"

namespace pliant {

struct VibrationFitOptions {
  SimulateOptions simulate;     ///< of the roll-outs; fps, duration, substeps and damping_time are the fit's
  ModesOptions modes;
  ModalSearchOptions search;
  GaussNewtonOptions refine;    ///< iterations and tolerance
  int candidates = 3;           ///< minima of the search that are refined
  int most_modes = 6;           ///< whose amplitudes are refined
  double most_periods = 8;      ///< of the strongest mode that roll-outs are compared over
  double noise = 0;             ///< of the tracks, in their unit; 0 = what remains
  std::vector<uint32_t> part;   ///< [N] of the particles, from 0 without gaps, whose E may differ; empty = one part
  double part_sigma = 0.5;      ///< decades by which a part is expected to differ from the common factor
};

/// What tracks say of a body whose Young's moduli are off by one factor, or by one for each part.
struct VibrationFit {
  double log10_factor = 0, log10_sigma = 0;  ///< of E of all parts; one standard deviation
  std::vector<double> part_log10, part_sigma;  ///< [parts] further factor of each, and its standard deviation; of which
                                               ///< `part_sigma` of the options is what the tracks say nothing about
  double damping_time = 0, damping_time_low = 0, damping_time_high = 0;  ///< s; within one standard deviation
  double time = 0;                 ///< s on the tracks' clock, at which the roll-out starts
  int first_frame = 0;             ///< of the tracks, that was compared
  SimulationState start;           ///< of the particles with the factor applied
  int subframes = 1;               ///< frames of the roll-out for one of the tracks
  double rms_search = 0, rms = 0;  ///< of tracks against roll-outs: from the best candidate of the search, and refined, over the frames compared
  double rms_rest = 0;             ///< if nothing moved
  VibrationModes modes;
  ModalSearch search;
  std::vector<double> candidate_factor, candidate_rms;  ///< the minima that were refined: log10 factor and rms after it
  GaussNewtonSummary summary;
  double seconds = 0;

  /// The particles with the fitted E.
  Particles fitted(const Particles& particles, const std::vector<uint32_t>& part) const;
  /// Frame of the roll-out that shows frame f of the tracks.
  int rollout_frame(int f, double fps) const;
};

/// Vibration modes; the search over log E; then Gauss-Newton on roll-outs of log E (of each part), damping and the
/// amplitudes of the strongest modes at the start.  `progress` gets a line for every stage.
VibrationFit fit_vibration(const VibrationFitOptions& options, const Particles& particles,
                           const std::vector<Interaction>& interactions, const TrackLoss<float>& tracks, double fps,
                           const std::function<void(const std::string&)>& progress = {});

}  // namespace pliant
