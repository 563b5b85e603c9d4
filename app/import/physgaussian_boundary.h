#pragma once

#include <nlohmann/json_fwd.hpp>

#include "app/import/physgaussian_config.h"
#include "gaussians/io/files/json_file.h"

namespace pliant {

/// Reads a row of boundary_conditions: `object`, whose values are those of `row`.  Throws Error{kUsage} for a type that
/// is not known, and for keys and values that are not of its form.
PhysGaussianConfig::Boundary read_physgaussian_boundary(const JsonObject& object, const nlohmann::json& row);

}  // namespace pliant
