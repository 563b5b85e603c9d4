#pragma once

#include <span>
#include <utility>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// Optical flow between pictures [H, W, 3] of one size: flow [H, W, 2] in pixels, such that what is at (x, y) in the
/// first is at (x, y) + flow(x, y) in the second.  Dense inverse search (Kroeger et al. 2016) as OpenCV implements it.
/// Its result depends on the number of threads inside OpenCV, so that OpenCV computes each pair on one thread; pairs
/// run side by side.  Equal for any number of threads.  Pairs are (from, to), indices of `frames`.
enum class FlowQuality { kQuick, kFine };
std::vector<ImageF> dense_flows(std::span<const ImageF> frames, std::span<const std::pair<int, int>> pairs,
                                FlowQuality quality = FlowQuality::kFine);

/// Bilinear value of one channel at image point (u, v), where pixel centres are at + 0.5; the border is continued.
float sample(const ImageF& picture, double u, double v, int channel);

}  // namespace pliant
