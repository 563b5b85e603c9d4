#pragma once

#include <array>

#include "gaussians/base/image.h"
#include "segmentation/models/tensor.h"

namespace pliant {

/// Linear interpolation between pixel centres with the filter widened by the scale where the picture shrinks, so that
/// every pixel counts: what the image libraries do on which the published networks were trained ("antialias").
ImageF resize_picture(const ImageF& picture, int width, int height);

/// A picture scaled to fit into a square or rectangle, in its upper left corner.
struct Fitted {
  ImageF picture;                  ///< [H, W, 3] of the rectangle
  float scale_x = 1, scale_y = 1;  ///< pixels of the rectangle for one of the original
  int width = 0, height = 0;       ///< of what is not padding
};

/// Scales by one factor until the picture just fits and fills the rest with `padding`.
Fitted fit_picture(const ImageF& picture, int width, int height, float padding);

/// How a network wants its colours: (255 * value - mean) / deviation per channel, red first unless `bgr`.
struct Normalisation {
  std::array<float, 3> mean{}, deviation{1, 1, 1};
  bool bgr = false;

  /// Mean and deviation of ImageNet.
  static Normalisation imagenet();
};

/// [1, 3, H, W] from [H, W, 3].
Tensor to_planes(const ImageF& picture, const Normalisation& normalisation);

}  // namespace pliant
