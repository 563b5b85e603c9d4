#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "app/run/run_directory.h"
#include "app/seed/fill_stage.h"
#include "physics/body/samples.h"

namespace pliant {

/// The regions that hold an object, in scene units: those of the scene file and of --pin-below, and where it touches
/// its support (`extract`, the summary of that stage), else its lowest tenth where nothing else holds it.  What is
/// found reaches up to half of the height of the solid `samples` at most, so that something can move, and holds
/// nothing of a solid too flat for that; it says so.  Throws Error{kUsage} where given regions cover the whole object.
std::vector<Region> object_pins(const Context& context, const Scene& scene, const FillStage& stage,
                                const nlohmann::json& extract, const GaussianCloud& object,
                                const SolidSamples& samples);

}  // namespace pliant
