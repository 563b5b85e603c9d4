#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run/options.h"
#include "app/run/stage_inputs.h"
#include "app/store/solid.h"
#include "gaussians/io/scene/scene.h"
#include "physics/loads/region.h"

namespace pliant {

/// fill, the first half of `pliant seed`: solid samples and what holds them -> objects/.../solid.h5.
struct FillStage {
  std::optional<int> particles;     ///< driving particles that the samples are made for; empty = kUsualParticles
  std::string physgaussian;         ///< file; a configuration of PhysGaussian whose cells the particles fill
  std::optional<double> pin_below;  ///< height along up, scene units
  bool pin_contact = true;          ///< pin where the object touches its support
};
constexpr int kUsualParticles = 8000;
/// Of the height, from below: what is fixed of an object that nothing holds or carries.
constexpr double kHeldShare = 0.1;

/// Its options, bound to the fields of `stage`.
OptionTable options_of(FillStage& stage);
StageInputs<FillStage> inputs_of(const RunDirectory& run, const Scene& scene, const FillStage& stage);
nlohmann::json run_fill(const Context& context, RunDirectory& run, const Scene& scene, const FillStage& stage);

/// The regions that hold an object, in scene units.
std::vector<Region> pinned_regions(const SolidFile& solid, const Scene& scene);
}  // namespace pliant
