#pragma once

#include "fitting/modal/modes.h"
#include "fitting/objective/track_loss.h"

namespace pliant {

struct ModalSearchOptions {
  double low = -2, high = 2;  ///< decades of E about the modes' own
  double farthest = 5;        ///< decades either way, to which the range grows while the best is at its end
  double step = 0.02;         ///< decades; narrow basins of many periods want .05 or less
  std::vector<double> damping_rates = {0.02, 0.1, 0.2, 0.4, 0.7, 1, 1.5, 2, 3, 5, 8};  ///< 1/s
  double ridge = 3e-4;  ///< prior of the amplitudes: modes of higher frequency and modes that no track sees stay small
  int starts = 4;       ///< possible starts of a roll-out between two frames of the tracks
  double first = -1;    ///< s, from which on the motion is free; negative = found
  int most_minima = 5;
};

/// Free vibration q_k(t) = exp(-rate_k s) (cosine_k cos(w_k s) + sine_k sin(w_k s)), s = t - time.
struct ModalMotion {
  double log10_factor = 0;                        ///< of E
  double damping_rate = 0;                        ///< 1/s, beyond the transfers' own
  double time = 0;                                ///< s
  std::vector<double> omega, rate, cosine, sine;  ///< [m]
  double unexplained = 1;                         ///< share of the tracks' squared displacement that it leaves
  double periods = 0;  ///< of the strongest mode, in the frames compared; of the minima of a search

  double displacement(size_t k, double t) const;
  double velocity(size_t k, double t) const;
};

struct ModalSearch {
  std::vector<double> log10_factor, unexplained;  ///< the curve: best over damping, for every candidate
  std::vector<ModalMotion> minima;                ///< local minima of the curve, best first; at least one
  int first_frame = 0;                            ///< of the tracks, from which on the motion is free
  double periods = 0;                             ///< of the best minimum, or of the one that a fit refined
  bool late = false;                              ///< first_frame is the last one considered: a push may last longer
  bool away = false;  ///< and the tracks are farthest from rest in the last frame: it may never end
  int end = 0;        ///< of the best minimum, or of the one that a fit refined: see end_of

  /// -1, 1 where a minimum lies at the low or high end of the curve, beyond which E may be anything; else 0.
  int end_of(const ModalMotion& minimum) const;
};

/// One-dimensional search over log E.  All E times a factor makes every vibration faster by its root and changes
/// nothing else, so the modes found once answer for all candidates; for each, amplitudes and phases that explain the
/// tracks follow from linear least squares.  The range grows while the best is at its end; where that leads nowhere,
/// the given range holds.  Tracks are of small or moderate displacements; what is found is where roll-outs are to
/// begin.  Throws Error{kInput} when nothing moves.
ModalSearch modal_search(const ModalSearchOptions& options, const VibrationModes& modes, const Particles& particles,
                         const TrackLoss<float>& tracks, double fps);

/// The state at time t of a vibration, in the particles' own time: x = X + sum q u, v = sum q' u, F and C alike.
SimulationState modal_state(const VibrationModes& modes, const Particles& particles,
                            const std::vector<double>& displacement, const std::vector<double>& velocity);

/// The latest time within half a period of the strongest mode before `time`, in steps of `step`, at which the body
/// passes nearest to its shape at rest: where a roll-out begins.
double time_near_rest(const ModalMotion& motion, double time, double step);

}  // namespace pliant
