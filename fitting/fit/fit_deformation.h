#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "fitting/fit/fit_gradient.h"

namespace pliant {

struct DeformationFitOptions {
  int iterations = 500;
  double rate = 0.01;       ///< of Adam; falls to a tenth by the end by a cosine
  double roughness = 1e-3;  ///< weight of the field's
  double clip = 1;          ///< largest norm of the gradient
  double fps = 24;          ///< of the frames, 1/s
};

struct DeformationFit {
  std::vector<SimulationState> frames;  ///< of the least loss
  /// Its rollout_seconds are those of the field's values, its field_seconds those of their adjoint.
  std::vector<GradientFitRow> iterations;
  double seconds = 0;
};

/// A motion without physics (DreamGaussian4D, Ren et al. 2023): frame k has every particle at its position at rest
/// plus `displacement` [frames, N, 3] m, whose parameters Adam finds by the derivatives of the objective by positions;
/// those by v, C and F do not count.  Frame 0 is the start at rest: the caller's field is 0 there and where the body is
/// held (WeightedField with deformation_weight).  v is the forward difference of neighbouring frames (the last has that
/// of the one before), C = 0, and F = I in every frame, as nothing is strained: Gaussians are carried by the rigid fit
/// of the particles around them.  Continues from `state` bit for bit: its parameters are `now.velocity` and
/// `best.velocity`, empty at a beginning, which is at no displacement.  The best is never worse than the start.  Throws
/// Error{kInterrupted} when `keep` says false, Error{kNumerical} where the loss has no finite derivatives.
DeformationFit fit_deformation(const DeformationFitOptions& options, const Particles& particles,
                               const Field& displacement, const Objective<float>& objective, GradientFitState state,
                               const std::function<void(const std::string&)>& progress = {},
                               const GradientFitSink& keep = {});

/// [frames * N] weights of a displacement: 0 in frame 0, `unit` [m] times `free` [N] (free_particles) in all others.
std::vector<double> deformation_weight(std::span<const double> free, int frames, double unit);

}  // namespace pliant
