#pragma once

#include <opencv2/core.hpp>

#include "gaussians/base/camera.h"

namespace pliant {

/// How the pixels of a pinhole camera are found in photos that were taken through a lens.
struct Undistortion {
  Camera pinhole;    ///< without distortion; pose, name and photo are those of the camera with the lens
  cv::Mat map_x, map_y;  ///< [H, W] float; where a pixel lies in the photo, for cv::remap
  bool all_inside = true;  ///< every pixel lies in the photo; else the map is -1 where it does not
};

/// The pinhole camera sees the largest upright rectangle that the photo covers, like COLMAP's image_undistorter.  Its
/// focal lengths are those of the lens, shorter when the rectangle would be larger than the photo.
/// Throws Error{kInput} naming the photo when the lens folds over so that no such rectangle is left.
Undistortion make_undistortion(const Camera& camera);

}  // namespace pliant
