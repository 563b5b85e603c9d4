#pragma once

#include <filesystem>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// Whether the folder holds cameras and images of COLMAP, binary or text.
bool is_colmap(const std::filesystem::path& folder);

/// A COLMAP model in a folder that is a number.
struct NumberedModel {
  std::filesystem::path folder;
  uint64_t images = 0;  ///< that it says it has; 0 when that cannot be true
};
/// The models <folder>/0, <folder>/1 and so on, by number.
std::vector<NumberedModel> numbered_models_in(const std::filesystem::path& folder);

/// Reads cameras.{bin,txt} and images.{bin,txt} of a COLMAP model; binary wins.  Camera models SIMPLE_PINHOLE, PINHOLE,
/// SIMPLE_RADIAL, RADIAL and OPENCV; an image with another is refused.  Axes and pixel centres are ours.  Photos are
/// looked for in `photos` (may be empty) and in the `images` folder of the model or of the folders around it.  Throws
/// Error{kInput} naming file, record and value.
CameraFile read_colmap(const std::filesystem::path& folder, const std::filesystem::path& photos = {},
                       PhotoFit fit = PhotoFit::kFirstPhoto);

}  // namespace pliant
