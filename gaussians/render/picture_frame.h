#pragma once

#include <optional>

#include "gaussians/base/camera.h"

namespace pliant {

/// The whole picture of which a camera draws a part, in pixels of the part.  The Jacobian of the projection is held
/// inside the frustum of the whole, so that the part looks as it does in the whole.
struct PictureFrame {
  double x = 0, y = 0;           ///< where the part begins in the whole
  double width = 0, height = 0;  ///< of the whole
};

/// A camera that draws a part of a picture.
struct PicturePart {
  Camera camera;
  PictureFrame frame;
};

/// The part of `camera`'s picture that begins at pixel (x, y).
inline PicturePart cropped(const Camera& camera, int x, int y, int width, int height) {
  PicturePart part{camera,
                   {static_cast<double>(x), static_cast<double>(y), static_cast<double>(camera.width),
                    static_cast<double>(camera.height)}};
  part.camera.cx -= x;
  part.camera.cy -= y;
  part.camera.width = width;
  part.camera.height = height;
  return part;
}

}  // namespace pliant
