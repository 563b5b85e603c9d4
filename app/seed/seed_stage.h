#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/seed/fill_stage.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// seed: solid samples and driving particles -> objects/.../particles.h5.
struct SeedStage {
  FillStage fill;
  std::string drivers = "kmeans";  ///< how they are placed: kmeans, or pgas (denser where E is small)
  std::string material_file;  ///< material.h5 of any particles, whose nearest sample says what E is to pgas; empty =
                              ///< as predicted, else the same everywhere
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(SeedStage& stage);
StageInputs<SeedStage> inputs_of(const RunDirectory& run, const Scene& scene, const SeedStage& stage);
/// Of an object that is filled.
nlohmann::json run_drivers(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage);
/// Fills the object first, where that is not done.
nlohmann::json run_seed(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage);

}  // namespace pliant
