#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/segment/label_models.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// repair: the hole that the object left -> background_repaired.ply, repair.png.
struct RepairStage {
  std::string shadow = "repair";  ///< of the object on its support, where it is plain: repair or keep
  ModelChoice models;             ///< of which the inpainter fills holes
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(RepairStage& stage);
StageInputs<RepairStage> inputs_of(const RunDirectory& run, const Scene& scene, const RepairStage& stage);
nlohmann::json run_repair(const Context& context, RunDirectory& run, const Scene& scene, const RepairStage& stage);

}  // namespace pliant
