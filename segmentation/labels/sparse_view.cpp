#include "segmentation/labels/sparse_view.h"

#include <algorithm>
#include <cmath>

namespace pliant {

CompactView compact_view(const BlendWeights& weights, std::span<const uint32_t> pixels, size_t gaussians) {
  constexpr float kOne = 65535.0f;
  CompactView view;
  view.unit = 1.0 / kOne;
  view.row_start.assign(1, 0);
  view.row_start.reserve(pixels.size() + 1);
  for (uint32_t pixel : pixels) {
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
      const float code = std::round(std::min(weights.weight[e], 1.0f) * kOne);
      if (code < 1.0f) continue;
      view.gaussian.push_back(weights.gaussian[e]);
      view.weight.push_back(static_cast<uint16_t>(code));
    }
    view.row_start.push_back(static_cast<uint32_t>(view.gaussian.size()));
  }
  view.gaussian.shrink_to_fit();
  view.weight.shrink_to_fit();
  view.index_columns(gaussians);
  return view;
}

}  // namespace pliant
