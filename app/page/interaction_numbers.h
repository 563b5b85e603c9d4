#pragma once

#include <span>
#include <vector>

#include "physics/simulate/interaction.h"

namespace pliant {

/// How many numbers a page, its solver and `pliant view` exchange for an interaction.
constexpr size_t kInteractionNumbers = 22;

/// Numbers of an interaction in SI units and world axes: type, duration (0 = until it is ended), kind of region, its
/// point [3], vector [3] and radius, vector [3], friction, rate, drag coefficient, air density, stiffness, damping,
/// largest force, contact, mass.  app/page/web/solver_layout.js has the same order.
std::vector<double> numbers_of(const Interaction& interaction);
/// The other way round; a poke begins where its region is.  Type and kinds must be those of the enumerations.
Interaction interaction_of(std::span<const double> numbers);

}  // namespace pliant
