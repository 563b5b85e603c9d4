#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/types.h"

namespace pliant {

/// Points of structure from motion.
struct SparsePoints {
  /// Camera number `camera` of those that were passed sees the point at `pixel`, through its own lens.
  struct Observation {
    int point, camera;
    Vec2f pixel;
  };

  std::vector<Vec3f> position;            ///< [N, 3] in the world of the cameras
  std::vector<Vec3f> color;               ///< [N, 3] in [0, 1]
  std::vector<Observation> observations;  ///< ordered by point; empty when the file has no tracks
  std::filesystem::path file;             ///< that they were read from; empty when they come from elsewhere
  std::string source;                     ///< where the points come from, or why there are none: a sentence
  std::vector<std::string> warnings;      ///< about points and observations that are left out

  bool empty() const { return position.empty(); }
};

/// The file that read_sparse_points reads, without reading it; empty when there is none.
std::filesystem::path sparse_points_file(const std::filesystem::path& path);

/// The points that belong to the cameras read from `path` (any path that read_cameras takes): points3D.{bin,txt} of a
/// COLMAP model, or the point cloud that `ply_file_path` of a transforms.json names.  Empty when there are none.
/// Observations are carried over to `cameras`, which are found by the names of their photos and may have been scaled,
/// undistorted or turned in the plane of the photo; with any other pose than in the model, the pixels stay where the
/// photo shows them.  Those of images or features that the model does not have are left out with a warning.  Throws
/// Error{kInput} naming file, record and value.
SparsePoints read_sparse_points(const std::filesystem::path& path, const std::vector<Camera>& cameras);

}  // namespace pliant
