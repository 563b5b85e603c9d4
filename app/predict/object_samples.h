#pragma once

#include <vector>

#include "app/run/run_directory.h"
#include "app/store/particles.h"
#include "fitting/distribution/material_object.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The solid samples of an object in metres, with the thickness of the driving particles that they follow.
SolidSamples samples_in_metres(const ParticleFile& file, double metres_per_unit);
/// [M] diffuse color of the Gaussian that is nearest to each position, 0..1.
std::vector<Vec3f> nearest_colours(const GaussianCloud& object, const std::vector<Vec3f>& positions);

/// The object of a finished fit, of which the distribution network may learn.  Throws Error{kUsage} where nothing was
/// fitted, or what was does not belong to what is there.
MaterialObject fitted_object(const RunDirectory& run, const Scene& scene);

}  // namespace pliant
