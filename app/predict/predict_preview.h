#pragma once

#include <filesystem>

#include "app/predict/predict_stage.h"

namespace pliant {

/// Refuses, before anything is predicted, what has no preview.  Throws Error{kUsage} where the object has no particles
/// yet, or E is given, by `stage` or the scene file, and has no band.
void check_preview(const RunDirectory& run, const Scene& scene, const PredictStage& stage);

/// Three short clips of the object as predicted, stiff, usual and soft (softness 0, .5 and 1), side by side ->
/// softness.mp4.  They are made in run directories of their own below `softness/`, which are kept: what is unchanged
/// there is not made again.  `stage` is that of a prediction that has run, whose answers of a language model they
/// share; its softness does not count.  Throws as check_preview.
std::filesystem::path run_preview(const Context& context, const RunDirectory& run, const Scene& scene,
                                  const PredictStage& stage);

}  // namespace pliant
