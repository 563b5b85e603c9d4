#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"

namespace pliant {

/// A camera that moves: one pose per frame.
struct CameraPath {
  double fps = 30;
  std::vector<Camera> cameras;
  std::vector<std::string> warnings;

  double duration() const { return static_cast<double>(cameras.size() - 1) / fps; }  ///< s, from first to last pose
  /// The camera at a time in s: rotation by spherical interpolation, centre and focal lengths linear; before the first
  /// and after the last pose it stands still.
  Camera at(double time) const;
};

/// Whether the file is a camera_path.json of nerfstudio.
bool is_camera_path(const std::filesystem::path& file);

/// Cameras in the order of their photos' paths, numbers as numbers; by their names where one has no photo.
void order_by_photo(std::vector<Camera>& cameras);

/// The cameras of a file or COLMAP model as views, which need no photos, at 30 per second.  Those of COLMAP, which it
/// lists in the order of its search, are in the order of their photos, others in that of the file.
CameraPath read_views(const std::filesystem::path& file);

/// Reads a camera path: the camera_path.json of nerfstudio's viewer (perspective; fov is vertical), or views of one
/// size.  Throws Error naming file, key and value.
CameraPath read_camera_path(const std::filesystem::path& file);

}  // namespace pliant
