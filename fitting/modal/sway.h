#pragma once

#include <optional>

#include "physics/simulate/simulate.h"

namespace pliant {

struct SwayOptions {
  Vec3d direction = Vec3d::UnitX();  ///< unit, of the velocity that the body starts with
  int max_substeps = 60000;
  GridKind grid = GridKind::kAutomatic;
};

/// Frequency [Hz] at which a held body sways along a direction: half of its period is the time until its centre of
/// mass, given a small uniform velocity, is back where it was.  Proportional to sqrt(E) when all E change alike.  None
/// when it has not come back in that many substeps.  Throws Error{kUsage} when nothing holds the body.
std::optional<double> sway_frequency(const SwayOptions& options, const Particles& particles,
                                     const std::vector<Interaction>& interactions);

}  // namespace pliant
