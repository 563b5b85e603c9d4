#pragma once

#include <string>

#include "physics/simulate/simulate.h"

namespace pliant {

/// Particles times time steps that a second of motion usually takes at most: a clip of four seconds takes less than
/// half a minute on two cores.
constexpr double kUsualParticleSteps = 1e8;

/// Sentence about a clip that takes much longer because its material is stiff for its cells, with what to do; empty for
/// others.  From the time step of the body at rest.
std::string describe_work(const SimulateOptions& options, const Particles& particles);

}  // namespace pliant
