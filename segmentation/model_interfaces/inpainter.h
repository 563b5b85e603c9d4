#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// Fills a part of a picture with what could be there (LaMa: Suvorov et al. 2022).
class Inpainter {
 public:
  virtual ~Inpainter() = default;
  /// picture [H, W, 3] sRGB in 0..1; mask [H, W, 1], 1 = fill.  Pixels outside the mask are returned as they came.
  virtual ImageF inpaint(const ImageF& picture, const ImageU8& mask) = 0;
};

}  // namespace pliant
