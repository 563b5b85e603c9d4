#pragma once

#include <filesystem>
#include <vector>

#include "gaussians/io/cameras/camera_file.h"
#include "gaussians/io/cameras/sparse_points.h"

namespace pliant {

/// The camera file or COLMAP folder to read when `path` names cameras: transforms*.json, cameras.json, a Middlebury
/// *_par.txt, a COLMAP model or one of its files, poses_bounds.npy.  Empty when it names something else.
std::filesystem::path cameras_at(const std::filesystem::path& path);

/// Which of several COLMAP models sparse/0, sparse/1 and so on, into which its mapper splits photos that do not
/// connect.
enum class ColmapChoice {
  kFirst,   ///< that from which 3DGS trains
  kLargest  ///< that with most images
};

/// The cameras that lie in a folder: transforms.json, transforms_train.json, another transforms*.json, cameras.json, a
/// COLMAP model (itself, sparse/<n>, sparse, colmap/sparse/<n>), *_par.txt, poses_bounds.npy, in this order.  Empty
/// when there are none.  Poses of `ns-export cameras` (nerfstudio) are passed over: they have no intrinsics.
std::filesystem::path cameras_in(const std::filesystem::path& folder, ColmapChoice choice = ColmapChoice::kFirst);

/// Of cameras that are one of several numbered COLMAP models, in a sentence, how many images it and the others have.
/// Empty for all others.
std::string other_models(const std::filesystem::path& cameras);

/// Reads cameras of any format, told by content.  Photos are looked for beside them and in `photos` (may be empty).
CameraFile read_cameras(const std::filesystem::path& path, const std::filesystem::path& photos = {},
                        PhotoFit fit = PhotoFit::kFirstPhoto);

/// Writes transforms.json, or the cameras.json of 3DGS when the file has that name.  Atomic.  Returns what the format
/// could not hold, in sentences for the user.  The points that belong to the cameras (may be none) are written beside a
/// transforms.json, to points_beside(file).
std::vector<std::string> write_cameras(const std::filesystem::path& file, const std::vector<Camera>& cameras,
                                       const SparsePoints& points = {});
/// <name>_points.ply beside a camera file.
std::filesystem::path points_beside(const std::filesystem::path& file);

}  // namespace pliant
