#pragma once

#include "physics/body/make_particles.h"

namespace pliant {

/// The homogeneous material field: the same E [Pa], nu and rho [kg/m^3] at each of `count` solid samples.  Throws
/// Error{kUsage} for impossible values.
ElasticSamples uniform_field(size_t count, double young, double poisson, double density);

}  // namespace pliant
