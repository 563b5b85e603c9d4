#pragma once

#include <span>
#include <vector>

#include "physics/laws/material.h"

namespace pliant {

/// How many numbers a page and its solver exchange for a material.
constexpr size_t kMaterialNumbers = 15;

/// Numbers of a material in SI units: its law and the constants in the order of Material, but for its damping time,
/// which is that of the simulation.
std::vector<double> numbers_of(const Material& material);
/// The other way round.  The law must be one of the enumeration.
Material material_of(std::span<const double> numbers);

}  // namespace pliant
