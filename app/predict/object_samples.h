#pragma once

#include <filesystem>
#include <vector>

#include "app/run/run_directory.h"
#include "app/store/solid.h"
#include "fitting/distribution/material_object.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// The solid samples of an object in metres.
SolidSamples samples_in_metres(const SolidFile& file, double metres_per_unit);
/// [M] diffuse color of the Gaussian that is nearest to each position, 0..1.
std::vector<Vec3f> nearest_colours(const GaussianCloud& object, const std::vector<Vec3f>& positions);

/// The object of a finished fit, of which the distribution network may learn.  Throws Error{kUsage} where nothing was
/// fitted, or what was does not belong to what is there.
MaterialObject fitted_object(const RunDirectory& run, const Scene& scene);

/// Every splat file NAME.* of a folder with a material field NAME.npz, NAME.field.ply or NAME.h5 beside it, of which
/// the network may learn too: the object alone, in metres, its up found by up_of_cloud, named as its family what stands
/// before the first digit, '-' or '_' of NAME.  Throws Error{kUsage} where there is none, and where two splat files or
/// two fields have one such NAME; Error{kInput} for a bad file.
std::vector<MaterialObject> splat_objects(const std::filesystem::path& folder, uint64_t seed);

}  // namespace pliant
