#pragma once

#include "gaussians/reconstruct/train_options.h"
#include "gaussians/reconstruct/training_state.h"

namespace pliant {

/// Opacity and factor of the standard deviations of each of `copies` Gaussians at one place that together look like
/// one of `opacity` (Kheradmand et al. 2024, eq. 9).
struct SharedOpacity {
  double opacity, scale;
};
SharedOpacity share_opacity(double opacity, int copies);

struct McmcSummary {
  size_t moved = 0, added = 0;
};

/// Moves Gaussians that have become transparent (or are not finite) onto living ones, drawn by opacity, and adds
/// copies until there are `wanted`; those that share a place share opacity and size so that the picture hardly changes.
McmcSummary relocate_and_grow(const TrainOptions& options, size_t wanted, TrainingState& state);

/// Adds Langevin noise to positions: covariance / extent^2 * normal, small for opaque Gaussians (same, eq. 8, where the
/// covariance is in scene units, so that the noise depends on the unit of length); `rate` is Adam's current learning
/// rate of positions.
void explore(const TrainOptions& options, float rate, float extent, TrainingState& state);

/// Adds the derivatives of opacity_weight * mean opacity + scale_weight * mean standard deviation / extent.
void add_mcmc_regularisers(const TrainOptions& options, float extent, const GaussianCloud& cloud,
                           CloudOf<float>& gradient);

}  // namespace pliant
