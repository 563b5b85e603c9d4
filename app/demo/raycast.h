#pragma once

#include "app/demo/stage.h"
#include "gaussians/base/image.h"

namespace pliant {

/// A view of the stage by ray casting.
struct DemoPhoto {
  ImageF color;  ///< [H, W, 3], mean of 3 x 3 rays a pixel
  IdImage ids;   ///< [H, W], what the ray through the pixel's centre meets; 0 = nothing
};
DemoPhoto take_photo(const Stage& stage, const Camera& camera);

constexpr int kSamplesAcross = 3;  ///< rays per pixel along each axis

/// Image coordinate of sample s of pixel i.
inline double sample_at(int i, int s) { return i + (s + 0.5) / kSamplesAcross; }

}  // namespace pliant
