#pragma once

#include <filesystem>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// Reads the cameras.json that 3DGS training writes: an array of {img_name, width, height, position, rotation, fx, fy},
/// position and rotation from camera to world in our axes; the principal point is the middle.  Photos are looked for in
/// `photos` (may be empty) and in `images` and `input` beside the file.  Throws Error naming file, entry and key.
CameraFile read_cameras_json(const std::filesystem::path& file, const std::filesystem::path& photos = {},
                             PhotoFit fit = PhotoFit::kFirstPhoto);

/// Writes the same, atomically.  It has no principal point and no distortion.
void write_cameras_json(const std::filesystem::path& file, const std::vector<Camera>& cameras);

}  // namespace pliant
