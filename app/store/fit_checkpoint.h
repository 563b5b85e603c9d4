#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "fitting/fit/fit_gradient.h"
#include "fitting/fit/fit_markers.h"
#include "fitting/fit/fit_vibration.h"
#include "fitting/fit/young_posterior.h"

namespace pliant {

/// What is done of a fit: the best constant, a field, and how far the stage is that comes next.
struct FitCheckpoint {
  std::optional<VibrationFit> homogeneous;  ///< without other minima of the search and the posterior of a field
  std::optional<VibrationFit> field;        ///< from there on; likewise
  VibrationFitState vibration;              ///< of the first of these that is not done
  GradientFitState velocity;                ///< of v0 alone, where a stage is about it
  GradientFitState gradient;
  PosteriorState posterior;  ///< about what gradients found
  MarkerFitState markers;
  std::string provenance_json;  ///< options and inputs of the fit
};

/// checkpoint.h5 of a fit; equal bit for bit when read again.
void write_fit_checkpoint(const std::filesystem::path& file, const FitCheckpoint& checkpoint);
/// Throws Error{kInput} naming file and dataset.
FitCheckpoint read_fit_checkpoint(const std::filesystem::path& file);
/// Only the provenance; empty when another version of Pliant wrote it, whose fits take other steps.
std::string read_fit_checkpoint_provenance(const std::filesystem::path& file);

}  // namespace pliant
