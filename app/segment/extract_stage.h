#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// extract: one object -> objects/<id>_<name>/object.ply, background.ply.
struct ExtractStage {
  std::string object;  ///< id or name; empty = the scene file's, else the one that choose_object() takes
  std::string label;   ///< what the user calls it, where it is left to choose_object()
  double threshold = 0.5;
  bool hull = false;  ///< what lies in the convex hull of the object belongs to it
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(ExtractStage& stage);
StageInputs<ExtractStage> inputs_of(const RunDirectory& run, const Scene& scene, const ExtractStage& stage);
nlohmann::json run_extract(const Context& context, RunDirectory& run, const Scene& scene, const ExtractStage& stage);

}  // namespace pliant
