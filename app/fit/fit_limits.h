#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/fit/fit_report.h"
#include "fitting/modal/dissipation.h"

namespace pliant {

struct MarkerFitOptions;
struct MarkerFitResult;

constexpr double kPoorFit = 0.7;  ///< of the RMSE if nothing moved, from which on a fit explains less than half

/// What a fit found, as far as it says how well the video determines it.
struct FitEvidence {
  double young = 0, log10_sigma = 0;                           ///< Pa, decades
  double stated_fps = 0;                                       ///< that times follow; 0 = not known
  double damping_time = 0, damping_low = 0, damping_high = 0;  ///< s
  Dissipation losses;                                          ///< of the motion; zero = not known
  double periods = 0;                                          ///< of the strongest mode
  double strongest_hz = 0;                                     ///< 0 = not known
  std::vector<double> rival_factor, rival_rms;  ///< other minima that were refined: E against the result's, rms
  int refined = -1;                             ///< which of these the result was refined from; -1 = not known
  double rms = 0;                               ///< of the result, in the same unit
  double rms_still = 0;                         ///< if nothing moved; 0 = not known
  bool searched = true;                         ///< E was, and damping was fitted
  bool one_stiffness = true;                    ///< for the whole object
  bool start_given = false;                     ///< factors of a given E(x) were fitted
  bool field_left = false;                      ///< a field was tried, and explained no more than one stiffness
  bool poisson_fitted = false, density_fitted = false;
  bool by_gradients = false;    ///< the errors are worked out about what gradients found
  bool errors_known = true;     ///< of E from place to place
  double undecided_volume = 0;  ///< share whose E the prior decides, not the video
  double displaced = 0;         ///< px, of the object in the first frame from its place at rest; 0 = at rest
  double start = 0;             ///< s of the video, from which on the motion is free
  bool start_late = false;      ///< that is the latest time considered
  bool pushed_away = false;     ///< and the object moves away to the last frame
  int search_end = 0;           ///< -1, 1: E comes from the low or high end of the search
  MotionScores scores;          ///< of the pictures; without frames = not known
};

/// Shares of a fitted motion that the video says little of.
struct FitBlindness {
  std::optional<double>
      depth_share;           ///< of the kinetic energy at the start, along the line of sight of the only camera
  double unseen_volume = 0;  ///< of what moves, farther than three cells from every point that was followed
  double stiff_volume = 0;   ///< that never deforms by more than a twentieth of what deforms most
};
FitBlindness find_blindness(const FitScene& fit, const FittedMotion& motion);

/// Why the result is not to be relied on, in sentences with what to do: the video does not begin at rest, the object is
/// still pushed, E is at the end of the search, or motion or pictures are explained poorly.
std::vector<std::string> doubts_of(const FitEvidence& evidence);

/// Plain sentences on what the video does not determine, doubts first.
std::vector<std::string> undetermined_by_video(const FitEvidence& evidence, const FitBlindness& blindness, double fps);

/// The same of a fit to markers: E is at the end of the search, the motion is explained poorly, the refinement did not
/// converge or the release was not found.
std::vector<std::string> doubts_of(const MarkerFitResult& fit, const MarkerFitOptions& options);

/// Plain sentences on what the recording does not determine, doubts first.  `gravity`: the load is the body's weight;
/// `start_given`: factors of a given E(x) were fitted.
std::vector<std::string> undetermined_by_markers(const MarkerFitResult& fit, const MarkerFitOptions& options,
                                                 bool gravity, bool start_given);

}  // namespace pliant
