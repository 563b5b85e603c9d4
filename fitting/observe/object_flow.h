#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// How an object and what is behind it move from one picture to another, where there is texture.
struct ObjectFlow {
  double object = 0;      ///< px, 95th percentile over the object, against the median of the background
  double background = 0;  ///< px, median length over the background
  double noise = 0;       ///< px, median distance of the background's flow from its own median
  size_t pixels = 0;      ///< of the background
};

/// From `flow` [H, W, 2] between the two and the `contrast` [H, W, 1] of the first (match_pictures.h).  `object` [H, W,
/// 1] is not 0 on the object in the first; the background is where `surroundings` [H, W, 1] is 0.
ObjectFlow object_flow(const ImageF& flow, const ImageF& contrast, const ImageU8& object, const ImageU8& surroundings);

}  // namespace pliant
