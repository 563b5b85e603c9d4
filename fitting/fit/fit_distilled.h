#pragma once

#include "fitting/fit/fit_clip.h"
#include "fitting/objective/clip_objective.h"
#include "physics/body/make_particles.h"

namespace pliant {

/// How Physics3D (Liu et al. 2024) and DreamPhysics (Huang et al. 2025) let a video model choose a material: constants
/// of every particle, whose gradient over the last substep of each frame (two of them with a branch, whose return map
/// ends a substep here) is scaled to its range over the particles and taken off their log10, as the released programs
/// do; or, as DreamPhysics' paper says, E is a network of places (kan_field.h).  Re-created from their descriptions and
/// released settings.
struct DistilledFitOptions {
  /// Bounds of a constant against where it starts, as the released bounds stand to the released starts.
  struct Range {
    double low, high;
  };

  int iterations = 50;  ///< each sees all frames once
  /// "Frame boosting": the frames of a roll-out are dealt out to so many clips, clip k with frames k, k + stages, ...
  int stages = 8;
  double rate = 1;             ///< of log10 of a constant, for a scaled gradient of 1
  bool network = false;        ///< E is a network of places, whose parameters are found by Adam; without a branch
  double network_rate = 0.01;  ///< of Adam
  uint64_t seed = 0;           ///< of the network's first parameters
  bool branch = false;  ///< the relaxing branch of a viscoelastic law too (Physics3D), else E alone (DreamPhysics)
  bool against_still = false;  ///< see GuidanceLoss
  Range young{0.5, 2};         ///< E: 1e6 to 4e6 Pa from 2e6
  Range modulus{0.02, 2};      ///< of the branch: 0.1 to 10 from 5
  Range viscosity{1, 1000};    ///< of the branch: 0.1 to 100 from 0.1

  static DistilledFitOptions physics3d();
  static DistilledFitOptions dreamphysics();
};

/// What a branch starts from where the scene has none: as stiff in shear as the particle, lambda alike, and a
/// relaxation time of 0.01 s in shear, that of Physics3D's released settings (viscosity / (2 mu) of 0.1 and 5).
RelaxingBranch usual_branch(double young, double poisson);

/// `motion`, whose particles have a material each for a branch (set_branches), with the constants that `guide` asks
/// for; its frames are options.stages times those of a clip.  `drawn`: what the guide sees of a roll-out at `fps`
/// frames a second, so that a clip has fps / options.stages.  `state` keeps log10 of factors of the start in
/// `now.material`: E [N], then shear, lambda and viscosity [N] each; or the network's parameters.  The last iteration
/// is the result.  Throws Error{kInterrupted} when `keep` says false.
ClipFit fit_distilled(const DistilledFitOptions& options, const Motion<float>& motion, const ClipTerms& drawn,
                      double fps, GradientFitState state, const std::function<void(const std::string&)>& progress = {},
                      const GradientFitSink& keep = {});

/// One step of the update rule: from log10 factors [N], by dL/d(constant) [N], within the range.
void distilled_step(double rate, const DistilledFitOptions::Range& range, std::span<const double> gradient,
                    std::span<double> log10_factor);

}  // namespace pliant
