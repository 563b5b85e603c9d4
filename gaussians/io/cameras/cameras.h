#pragma once

#include <filesystem>
#include <vector>

#include "gaussians/io/cameras/camera_file.h"

namespace pliant {

/// The camera file or COLMAP folder to read when `path` names cameras: transforms*.json, cameras.json, a Middlebury
/// *_par.txt, a COLMAP model or one of its files, poses_bounds.npy.  Empty when it names something else.
std::filesystem::path cameras_at(const std::filesystem::path& path);

/// The cameras that lie in a folder: transforms.json, transforms_train.json, another transforms*.json, cameras.json, a
/// COLMAP model (itself, sparse/0, sparse, colmap/sparse/0), *_par.txt, poses_bounds.npy, in this order.  Empty when
/// there are none.
std::filesystem::path cameras_in(const std::filesystem::path& folder);

/// Reads cameras of any format, told by content.  Photos are looked for beside them and in `photos` (may be empty).
CameraFile read_cameras(const std::filesystem::path& path, const std::filesystem::path& photos = {},
                        PhotoFit fit = PhotoFit::kFirstPhoto);

/// Writes transforms.json, or the cameras.json of 3DGS when the file has that name.  Atomic.  Returns what the format
/// could not hold, in sentences for the user.
std::vector<std::string> write_cameras(const std::filesystem::path& file, const std::vector<Camera>& cameras);

}  // namespace pliant
