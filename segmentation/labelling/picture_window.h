#pragma once

#include "gaussians/base/image.h"
#include "gaussians/base/types.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"

namespace pliant {

/// A rectangle of a picture at another resolution.  Window pixel (i, j) has its centre at (i + 0.5, j + 0.5).
class PictureWindow {
 public:
  /// `area` [px of the picture], cut off at the picture's border, with `longest` px on its longer side.
  PictureWindow(int picture_width, int picture_height, const MaskPrompt::Box& area, int longest);

  int width = 0, height = 0;           ///< of the window
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< [px of the picture], whole pixels, x1 and y1 behind the last

  Vec2f to_window(float x, float y) const { return {(x - x0) * scale_x(), (y - y0) * scale_y()}; }
  float scale_x() const { return static_cast<float>(width) / static_cast<float>(x1 - x0); }
  float scale_y() const { return static_cast<float>(height) / static_cast<float>(y1 - y0); }

  /// What the window shows of `picture`, any number of channels: mean over areas when it gets smaller, else bilinear.
  ImageF read(const ImageF& picture) const;
  /// The window's values [height, width, 1] laid over a picture that is `outside` elsewhere.
  ImageF write(const ImageF& values, int picture_width, int picture_height, float outside) const;
};

}  // namespace pliant
