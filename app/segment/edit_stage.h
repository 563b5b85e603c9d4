#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"
#include "segmentation/objects/edit.h"

namespace pliant {

/// segment edit: changes the objects of a run directory by hand; run.json keeps what was done.
struct EditStage {
  std::vector<ObjectEdit> edits;  ///< in the order in which they are applied
};
nlohmann::json run_edit(const Context& context, RunDirectory& run, const Scene& scene, const EditStage& stage);

}  // namespace pliant
