#pragma once

#include "app/reconstruct/reconstruct_stage.h"
#include "gaussians/reconstruct/trainer.h"

namespace pliant {

/// Trains to the end: progress, every twentieth a measurement of held-out photos and `preview`, a picture of one photo
/// beside its render, but seldomer where these would take more than a twentieth of a limited time; `save` now and then
/// (stage.checkpoint_every).  When interrupted it saves and throws Error{kInterrupted}; a loss that is not finite is an
/// Error{kNumerical}, and what was saved before stays.
void train_to_end(const Context& context, const ReconstructStage& stage, const TrainingPhotos& photos, Trainer& trainer,
                  const std::filesystem::path& preview, const std::function<void(const TrainingState&)>& save);

}  // namespace pliant
