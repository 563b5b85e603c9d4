#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/options.h"
#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// export: numbered splat files of the moving scene, or its material, outside of the run directory.
struct ExportStage {
  std::string ply_sequence;         ///< folder; sequence.json there says what the files are
  std::string physgaussian_output;  ///< folder for simulation_ply/sim_*.h5 and .ply
  std::string material;             ///< file for E, nu and rho of the object, .npz or .ply (material_fields.h)
  int every = 1;                    ///< take every Nth frame of the trajectory
  bool recorded = false;            ///< what `simulate --recording` wrote instead of the simulated motion
  bool object_only = false;         ///< without the background
};
/// Its options, bound to the fields of `stage`.
OptionTable options_of(ExportStage& stage);
nlohmann::json run_export(const Context& context, RunDirectory& run, const Scene& scene, const ExportStage& stage);

}  // namespace pliant
