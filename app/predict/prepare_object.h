#pragma once

#include "app/predict/predict_stage.h"
#include "app/seed/seed_stage.h"
#include "app/segment/extract_stage.h"
#include "app/segment/repair_stage.h"

namespace pliant {

/// The stages between the choice of an object and its simulation.
struct ObjectStages {
  ExtractStage extract;
  std::optional<RepairStage> repair;  ///< none: the hole stays as it is
  SeedStage seed;
  PredictStage predict;
};

/// extract, repair, fill, predict and drivers of an object of a segmented scene.  What `simulate` leaves open of the
/// material is predicted (the result; null where nothing is); `simulate` then has no value that the prediction has
/// used.  Where the object's height says how large the scene is, `scene` is scaled.
nlohmann::json prepare_object(const Context& context, RunDirectory& run, Scene& scene, const ObjectStages& stages,
                              SimulateStage& simulate);

/// The material with which a fit starts: what neither the command line, by `material`, nor the scene file says is as
/// predicted, and so is what of the scene file does not count beside the prediction that was asked for.
void start_from_prediction(const nlohmann::json& prediction, const Scene& scene, const PredictStage& asked,
                           MaterialValues& material);

}  // namespace pliant
