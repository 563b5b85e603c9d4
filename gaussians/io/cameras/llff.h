#pragma once

#include <filesystem>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// Reads the poses_bounds.npy of LLFF (Mildenhall et al. 2019): a row for each photo in the order of their names, [3,
/// 5] row by row and the depth bounds, which are not used.  Its columns are the axes down, right and back, the centre,
/// and (height, width, focal length) of the full photos.  The photos are those in `photos`, else in images, images_2,
/// images_4 or images_8 beside the file.  Throws Error{kInput} naming file, row and value.
CameraFile read_llff(const std::filesystem::path& file, const std::filesystem::path& photos = {},
                     PhotoFit fit = PhotoFit::kFirstPhoto);

}  // namespace pliant
