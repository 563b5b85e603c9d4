#pragma once

#include <filesystem>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// Reads a *_par.txt of the Middlebury multi-view sets (Seitz et al. 2006): a count, then one line for each photo:
/// name, K row by row, R row by row, t, with K [R t] the projection.  The sizes are those of the photos beside the file
/// or in `photos`, without photos twice the principal point.  Throws Error{kInput} naming file, line and value.
CameraFile read_middlebury(const std::filesystem::path& file, const std::filesystem::path& photos = {},
                           PhotoFit fit = PhotoFit::kFirstPhoto);

}  // namespace pliant
