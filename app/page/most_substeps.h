#pragma once

#include "physics/simulate/simulate.h"

namespace pliant {

/// Substeps at which a frame that a person waits for is given up: `many`, unless the body at rest, or with its
/// stiffness of now, needs about as many.
int most_substeps(const SimulateOptions& options, const Particles& particles, double young_scale, double many);

}  // namespace pliant
