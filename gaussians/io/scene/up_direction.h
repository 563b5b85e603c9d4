#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

struct UpDirection {
  Eigen::Vector3d up = {0, -1, 0};  ///< unit
  std::string source;               ///< how it was found, a sentence
};

/// The direction of that name: x, y, z, -x, -y or -z; empty for other texts.
std::optional<Eigen::Vector3d> axis_of_name(const std::string& name);

/// Whether an up direction, a unit vector, counts as +z: within 40 degrees.
bool is_near_z(const Eigen::Vector3d& up);

/// The direction to which the rows of the cameras' pictures are perpendicular: cameras are pitched, which tilts the
/// mean of those that do not surround a scene, but rarely rolled.  Where the rows are too much alike or disagree, the
/// mean picture-up of at least 3 cameras that agree roughly.  Pictures are upright as the EXIF orientation of their
/// photos says, where the cameras have the size of the stored photos.
std::optional<UpDirection> up_of_cameras(const std::vector<Camera>& cameras);

/// Normal of the plane that the cloud stands on: RANSAC (Fischler and Bolles 1981) over opacity-weighted positions,
/// oriented so that what is not in the plane lies above it.  Empty unless the plane holds at least 1/5 of the
/// opacity, has nearly nothing below it, and is either near the usual vertical (-y) or wider than what stands on it.
/// Deterministic.
std::optional<UpDirection> up_of_support_plane(const GaussianCloud& cloud);

/// For a thing without a ground: -y, the usual up of reconstructed scenes, unless the thing would stand clearly wider
/// the other way round.
UpDirection up_of_standing(const GaussianCloud& cloud);

/// Up of a cloud without cameras: of its support plane, else as it stands; of a file that declares z its vertical axis,
/// the normal of a support plane near z, else z.
UpDirection up_of_cloud(const GaussianCloud& cloud, bool z_is_up = false);

}  // namespace pliant
