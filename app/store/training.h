#pragma once

#include <filesystem>
#include <string>

#include "gaussians/reconstruct/training_state.h"

namespace pliant {

/// A training that can be gone on with.
struct TrainingCheckpoint {
  TrainingState state;
  std::string start_json;       ///< where the Gaussians came from
  std::string provenance_json;  ///< options and inputs of the training
};

/// checkpoint.h5: /gaussians/<array> [N, width] for each array of visit_gaussian_arrays that is in use; /shared,
/// /exposure [photos, 12] and their moments; /curve [M, 5] iteration, seconds, Gaussians, PSNR, SSIM.
void write_training(const std::filesystem::path& file, const TrainingCheckpoint& checkpoint);
/// Equal bit for bit to what was written.  Throws Error{kInput} naming file and dataset.
TrainingCheckpoint read_training(const std::filesystem::path& file);
/// Only the provenance.
std::string read_training_provenance(const std::filesystem::path& file);

}  // namespace pliant
