#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/fit/fit_report.h"
#include "fitting/modal/dissipation.h"

namespace pliant {

/// What a fit found, as far as it says how well the video determines it.
struct FitEvidence {
  double young = 0, log10_sigma = 0;                           ///< Pa, decades
  double stated_fps = 0;                                       ///< that times follow; 0 = not known
  double damping_time = 0, damping_low = 0, damping_high = 0;  ///< s
  Dissipation losses;                                          ///< of the motion; zero = not known
  double periods = 0;                                          ///< of the strongest mode
  double strongest_hz = 0;                                     ///< 0 = not known
  std::vector<double> rival_factor, rival_rms;  ///< other minima that were refined: E against the result's, rms
  double rms = 0;                               ///< of the result, in the same unit
  double rms_still = 0;                         ///< if nothing moved; 0 = not known
  bool searched = true;                         ///< E was, and damping was fitted
  bool one_stiffness = true;                    ///< for the whole object
  bool field_left = false;                      ///< a field was tried, and explained no more than one stiffness
  bool poisson_fitted = false;
  bool by_gradients = false;    ///< the errors are worked out about what gradients found
  bool errors_known = true;     ///< of E from place to place
  double undecided_volume = 0;  ///< share whose E the prior decides, not the video
};

/// Shares of a fitted motion that the video says little of.
struct FitBlindness {
  std::optional<double>
      depth_share;           ///< of the kinetic energy at the start, along the line of sight of the only camera
  double unseen_volume = 0;  ///< of what moves, farther than three cells from every point that was followed
  double stiff_volume = 0;   ///< that never deforms by more than a twentieth of what deforms most
};
FitBlindness find_blindness(const FitScene& fit, const FittedMotion& motion);

/// Why the result is not to be relied on: the motion that was found leaves most of the video's unexplained; else empty.
std::string poor_fit(const FitEvidence& evidence);

/// Plain sentences on what the video does not determine.
std::vector<std::string> undetermined_by_video(const FitEvidence& evidence, const FitBlindness& blindness, double fps);

}  // namespace pliant
