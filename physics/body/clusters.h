#pragma once

#include "physics/body/driving_particles.h"

namespace pliant {

/// Throws Error{kUsage} when there are no samples, or the wanted number of drivers is not positive.
void check_count(const SolidSamples& samples, int count);

/// Gives every sample to the nearest driver.
void assign_nearest(const SolidSamples& samples, DrivingParticles& drivers);

/// Volume-weighted centroids and volumes of the drivers' samples, summed in the order of the samples.  A driver without
/// samples stays where it is.
void update_centres(const SolidSamples& samples, DrivingParticles& drivers);

}  // namespace pliant
