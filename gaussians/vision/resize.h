#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// A picture [H, W, 3] at another size, averaged over areas when it shrinks, bilinear when it grows.
ImageF resized(const ImageF& picture, int width, int height);

}  // namespace pliant
