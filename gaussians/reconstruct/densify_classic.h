#pragma once

#include "gaussians/reconstruct/train_options.h"
#include "gaussians/reconstruct/training_state.h"

namespace pliant {

/// Adds what a picture says about where detail is missing: the length of dL/d(u, v) of the Gaussians in view, in half
/// image sizes.  `screen` [N, 2] in pixels, zero for those not in view.
void gather_screen_gradient(std::span<const Vec2f> screen, int width, int height, TrainingState& state);

struct ClassicSummary {
  size_t cloned = 0, split = 0, pruned = 0;
};

/// Clones small Gaussians and splits large ones whose mean screen gradient is above the threshold, largest gradients
/// first while the budget lasts, and prunes transparent ones (Kerbl et al. 2023, section 5.2).
ClassicSummary clone_split_prune(const TrainOptions& options, float extent, size_t budget, TrainingState& state);

/// Lowers all opacities to 0.01 at most.
void reset_opacities(TrainingState& state);

}  // namespace pliant
