#pragma once

#include <functional>
#include <limits>
#include <string>

#include "fitting/fit/marker_model.h"
#include "fitting/solve/gauss_newton.h"

namespace pliant {

struct MarkerFitOptions {
  MarkerModelOptions model;
  double window = 1;                                             ///< s from the release on that count
  double rest_begin = -std::numeric_limits<double>::infinity();  ///< s of the recording; from here to the release the
                                                                 ///< body is at rest
  double release = std::numeric_limits<double>::quiet_NaN();     ///< s of the recording; NaN = where motion sets in
  double release_range = 0.03;                                   ///< s, how far from there the fit looks
  double damping_time = 0.3;                                     ///< s, where the fit starts
  bool fit_young = true, fit_damping = true, fit_release = true;
  bool search = true;           ///< E by a search over its logarithm first; without it, from the particles' E
  double search_decades = 1.5;  ///< either side, that one simulated motion stands for
  double search_farthest = 5;   ///< either side, to which simulations go on while they explain the motion better, and
                                ///< which holds for Gauss-Newton as well
  double search_step = 0.05;    ///< decades; finer for a recording of very many periods
  double sigma = 5e-4;          ///< m, by which a coordinate may differ
  int max_iterations = 12;      ///< of Gauss-Newton
  Eigen::MatrixXd jacobian;     ///< of a fit of the same recording and window on a coarser grid, to save simulations
};

struct MarkerFitResult {
  MarkerParameters parameters;
  double young = 0;              ///< Pa, mean over the volume of log E
  double sigma_log10_young = 0;  ///< the deviations allow for errors correlated in time and between neighbours; 0 = not
                                 ///< fitted.  At least 1 at an end of the search, at most search_farthest or 1
  int search_end = 0;  ///< -1, 1: E is the least or largest that the fit looks at, and beyond it may be anything
  double sigma_log_damping = 0, sigma_release = 0;
  std::vector<int> markers;        ///< those on the body
  MarkerTracks expected;           ///< at the recorded instants of the window, those markers
  double rms = 0;                  ///< m, distance of expected and measured places after the release
  double rms_still = 0;            ///< m, the same if nothing moved
  Vec3d rms_axis = Vec3d::Zero();  ///< m, along each axis
  struct Candidate {
    double young, rms;  ///< Pa; m, distance of expected and measured places
  };
  std::vector<Candidate> search;  ///< simulated ones, in order
  std::vector<double> loss;       ///< of Gauss-Newton
  Eigen::MatrixXd jacobian;       ///< of its residuals
  bool converged = false;
  int rollouts = 0;
  double simulated_seconds = 0, seconds = 0;
  std::vector<std::string> warnings;
};

/// How far a fit is: it goes on from here, and ends as if it had not been interrupted.
struct MarkerFitState {
  struct Simulated {
    int step;     ///< of the grid over log E
    double loss;  ///< infinite where it cannot be simulated
  };
  std::vector<Simulated> simulated;  ///< in order
  bool searched = false;             ///< `best` is what the search ended with
  int best = 0;                      ///< step of the grid
  GaussNewtonState refinement;
};

/// Called after every candidate of the search and in every iteration of Gauss-Newton.  What it throws ends the fit.
using MarkerFitSink = std::function<void(const MarkerFitState&)>;

/// E (one factor on the particles' E), damping and release instant of a body from the motion of markers on it, after it
/// was let go from rest under `interactions`, whose times count from the release.
/// Search: one simulated motion stands for other E as well, because an elastic body's motion keeps its shape when time
/// goes as E^-1/2 and displacement as 1/E (exactly so for small strains).  The best candidate is simulated and the
/// proposal repeated from there; neighbours on the grid are compared by simulation.  Then Gauss-Newton.  Spikes of the
/// recording count as gaps (without_spikes), with a warning.
/// `progress` gets a line for every simulated candidate and for the refined result; it may throw to end the fit.
/// What `state` holds of an earlier call of the same options and inputs is not done again.
/// Throws Error{kInput} when no marker lies on the body, nothing moves or too little was measured in the window, and
/// Error{kUsage} for a release that is not within the recording from `rest_begin` on.
MarkerFitResult fit_markers(const MarkerFitOptions& options, const Particles& particles,
                            const std::vector<Interaction>& interactions, const MarkerTracks& tracks,
                            const std::function<void(const std::string&)>& progress = {}, MarkerFitState state = {},
                            const MarkerFitSink& sink = {});

}  // namespace pliant
