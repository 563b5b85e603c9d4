#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// seed: solid samples and driving particles -> objects/.../particles.h5.
struct SeedStage {
  int particles = 8000;
  std::string drivers = "kmeans";  ///< how they are placed: kmeans, or pgas (denser where E is small)
  std::string material_file;  ///< material.h5 of any particles, whose nearest sample says what E is to pgas; empty =
                              ///< the same everywhere
  std::string physgaussian;   ///< file; a configuration of PhysGaussian whose cells the particles fill
  std::optional<double> pin_below;  ///< height along up, scene units
  bool pin_contact = true;          ///< pin where the object touches its support
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(SeedStage& stage);
StageInputs<SeedStage> inputs_of(const RunDirectory& run, const Scene& scene, const SeedStage& stage);
nlohmann::json run_seed(const Context& context, RunDirectory& run, const Scene& scene, const SeedStage& stage);

}  // namespace pliant
