#pragma once

#include <filesystem>
#include <vector>

#include "gaussians/base/camera.h"

namespace pliant {

/// A camera that moves: one pose per frame.
struct CameraPath {
  double fps = 30;
  std::vector<Camera> cameras;

  double duration() const { return static_cast<double>(cameras.size() - 1) / fps; }  ///< s, from first to last pose
  /// The camera at a time in s: rotation by spherical interpolation, centre and focal lengths linear; before the first
  /// and after the last pose it stands still.
  Camera at(double time) const;
};

/// Whether the file is a camera_path.json of nerfstudio.
bool is_camera_path(const std::filesystem::path& file);

/// Reads a camera path: the camera_path.json of nerfstudio's viewer (perspective; fov is vertical), or the cameras of
/// any camera file in their order, 30 per second.  Throws Error naming file, key and value.
CameraPath read_camera_path(const std::filesystem::path& file);

}  // namespace pliant
