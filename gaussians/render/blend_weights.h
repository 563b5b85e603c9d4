#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/render/render.h"

namespace pliant {

/// Sparse matrix W [pixels, N] of one view: w = alpha_p * prod_{j < p} (1 - alpha_j), the weights with which any
/// per-Gaussian attribute is blended (compressed rows, Gaussians of a pixel in front-to-back order).
struct BlendWeights {
  int width = 0, height = 0;
  std::vector<uint32_t> row_start;  ///< [pixels + 1]
  std::vector<uint32_t> gaussian;   ///< [entries]
  std::vector<float> weight;        ///< [entries]

  size_t pixels() const { return static_cast<size_t>(width) * height; }
};

/// The weights that `render` uses for this view, entry by entry.
BlendWeights blend_weights(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options = {});

}  // namespace pliant
