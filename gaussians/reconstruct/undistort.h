#pragma once

#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/image.h"
#include "gaussians/base/types.h"

namespace pliant {

/// How the pixels of a pinhole camera are found in photos that were taken through a lens.
struct Undistortion {
  Camera pinhole;           ///< without distortion; pose, name and photo are those of the camera with the lens
  std::vector<Vec2f> seen;  ///< [H * W] image point of the photo that a pixel shows; NaN where it shows none
  bool all_inside = true;   ///< every pixel lies in the photo
};

/// The pinhole camera sees the largest upright rectangle that the photo covers, like COLMAP's image_undistorter.  Its
/// focal lengths are those of the lens, shorter when the rectangle would be larger than the photo.
/// Throws Error{kInput} naming the photo when the lens folds over so that no such rectangle is left.
Undistortion make_undistortion(const Camera& camera);

/// How `pinhole` finds its pixels in the photo that `camera` took from the same place in the same direction.
Undistortion undistortion_onto(const Camera& pinhole, const Camera& camera);

/// The picture of the pinhole camera, by Catmull-Rom interpolation, which keeps straight ramps in place; [H, W, C].
/// Black where the photo shows nothing.
ImageU8 undistorted(const Undistortion& lens, const ImageU8& photo);
ImageF undistorted(const Undistortion& lens, const ImageF& photo);  ///< in [0, 1]

}  // namespace pliant
