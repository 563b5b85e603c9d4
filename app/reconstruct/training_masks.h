#pragma once

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/reconstruct/training_photos.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// The ids that a pinhole camera sees, from a picture of ids of a camera with a lens in the same place: the nearest
/// pixel.
IdImage ids_through_pinhole(const IdImage& ids, const Camera& lens, const Camera& pinhole);

/// Masks in `folder`, drawn over the photos of `cameras` at any size, as they belong to the photos that are trained on:
/// views[].camera indexes these.  Throws Error{kInput} as load_masks does.
MaskSet training_masks(const std::filesystem::path& folder, const std::filesystem::path& labels,
                       const CameraFile& cameras, const TrainingPhotos& photos);

}  // namespace pliant
