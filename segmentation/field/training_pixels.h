#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "gaussians/base/random.h"
#include "gaussians/render/blend_weights.h"

namespace pliant {

/// Class of every pixel, -1 = unlabelled; `class_id` ascending, holds every id of the picture.
std::vector<int> classes_of(const IdImage& ids, const std::vector<uint32_t>& class_id);

/// Mean depth of every pixel, 0 where nothing is.
std::vector<float> depth_of(const BlendWeights& weights, const GaussianCloud& cloud, const Camera& camera);

/// Classes with the uncertain pixels of silhouettes set to -1: splats are blurred by the rasteriser's low-pass and
/// stick out of the silhouette, where they would learn the label of what is behind.  A pixel is uncertain when within
/// `border` pixels another id or none lies across a jump in depth (a surface seen flatter than 1 : 4 counts as one);
/// where an id is so thin that nothing certain of it is near, it is kept.
std::vector<int> without_silhouettes(const std::vector<int>& cls, const std::vector<float>& depth, const Camera& camera,
                                     int border);

struct ChosenPixels {
  std::vector<uint32_t> pixels;  ///< ascending within a block
  std::vector<int> target;       ///< their classes
};

/// Labelled pixels to learn from: all within `edge` pixels of another class, and one per stride x stride block, drawn
/// evenly inside it, elsewhere.
ChosenPixels choose_pixels(const std::vector<int>& cls, int width, int height, int stride, int edge, Random random);

}  // namespace pliant
