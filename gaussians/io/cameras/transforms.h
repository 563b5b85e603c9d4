#pragma once

#include <filesystem>
#include <vector>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// Reads nerfstudio's transforms.json (intrinsics for all frames or per frame) or Blender's (camera_angle_x).
/// The file's OpenGL axes (x right, y up, z back) are flipped here to ours; pixel centres are at (i + 0.5, j + 0.5)
/// in both.  Photos are looked for beside the file and in `photos` (may be empty), with or without suffix.  Frames
/// without a photo are left out when at least one frame has one.  Lens distortion is kept and warned about;
/// fisheye lenses and k4, the coefficient of r^8, are refused.  mask_path is ignored with a warning;
/// different values of `time`, as of D-NeRF, are warned about.
/// Throws Error naming file, frame and key.
CameraFile read_transforms(const std::filesystem::path& file, const std::filesystem::path& photos = {},
                           PhotoFit fit = PhotoFit::kFirstPhoto);

/// Writes nerfstudio's layout; photos, and the PLY of points that belong to the cameras (may be empty), are named
/// relative to the folder of `file`.  Atomic.
void write_transforms(const std::filesystem::path& file, const std::vector<Camera>& cameras,
                      const std::filesystem::path& points = {});

}  // namespace pliant
