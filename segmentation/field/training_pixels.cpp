#include "segmentation/field/training_pixels.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/portable.h"

namespace pliant {

std::vector<int> classes_of(const IdImage& ids, const std::vector<uint32_t>& class_id) {
  std::vector<int> cls(ids.data.size(), -1);
  for (size_t i = 0; i < cls.size(); ++i) {
    if (ids.data[i] == 0) continue;
    const auto it = std::lower_bound(class_id.begin(), class_id.end(), ids.data[i]);
    cls[i] = static_cast<int>(it - class_id.begin());
  }
  return cls;
}

std::vector<float> depth_of(const BlendWeights& weights, const GaussianCloud& cloud, const Camera& camera) {
  std::vector<float> depth(weights.pixels(), 0.0f);
  const Vec3f forward = camera.forward().cast<float>(), eye = camera.centre().cast<float>();
  parallel_for(
      static_cast<std::ptrdiff_t>(depth.size()),
      [&](std::ptrdiff_t i) {
        float sum = 0, total = 0;
        for (uint32_t e = weights.row_start[i]; e < weights.row_start[i + 1]; ++e) {
          sum += weights.weight[e] * forward.dot(cloud.position[weights.gaussian[e]] - eye);
          total += weights.weight[e];
        }
        if (total > 0) depth[i] = sum / total;
      },
      2048);
  return depth;
}

std::vector<int> without_silhouettes(const std::vector<int>& cls, const std::vector<float>& depth, const Camera& camera,
                                     int border) {
  if (border <= 0) return cls;
  const int width = camera.width, height = camera.height;
  const float jump = static_cast<float>(4 * border / camera.fx);  // over the depth
  auto any_near = [&](int x, int y, int radius, auto&& test) {
    for (int j = std::max(0, y - radius); j <= std::min(height - 1, y + radius); ++j)
      for (int i = std::max(0, x - radius); i <= std::min(width - 1, x + radius); ++i)
        if (test(static_cast<size_t>(j) * width + i)) return true;
    return false;
  };
  std::vector<uint8_t> uncertain(cls.size(), 0);
  parallel_for(
      height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < width; ++x) {
          const size_t own = y * width + x;
          uncertain[own] =
              cls[own] >= 0 && any_near(x, static_cast<int>(y), border, [&](size_t i) {
                return cls[i] != cls[own] && std::abs(depth[i] - depth[own]) > jump * std::min(depth[i], depth[own]);
              });
        }
      },
      16);
  std::vector<int> kept = cls;
  parallel_for(
      height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < width; ++x) {
          const size_t own = y * width + x;
          if (uncertain[own] && any_near(x, static_cast<int>(y), 2 * border,
                                         [&](size_t i) { return cls[i] == cls[own] && !uncertain[i]; }))
            kept[own] = -1;
        }
      },
      16);
  return kept;
}

namespace {

/// Labelled pixels with another class within `edge` pixels along the row or column.
std::vector<uint8_t> near_edges(const std::vector<int>& cls, int width, int height, int edge) {
  std::vector<uint8_t> near(cls.size(), 0);
  if (edge <= 0) return near;
  parallel_for(
      height,
      [&](std::ptrdiff_t y) {
        for (int x = 0; x < width; ++x) {
          const size_t own = y * width + x;
          const auto differs = [&](std::ptrdiff_t i, std::ptrdiff_t j) {
            if (i < 0 || j < 0 || i >= width || j >= height) return false;
            const int other = cls[j * width + i];
            return other >= 0 && other != cls[own];
          };
          for (int d = 1; d <= edge && cls[own] >= 0 && !near[own]; ++d)
            near[own] = differs(x - d, y) || differs(x + d, y) || differs(x, y - d) || differs(x, y + d);
        }
      },
      16);
  return near;
}

}  // namespace

ChosenPixels choose_pixels(const std::vector<int>& cls, int width, int height, int stride, int edge, Random random) {
  ChosenPixels chosen;
  const std::vector<uint8_t> near = near_edges(cls, width, height, edge);
  for (int y0 = 0; y0 < height; y0 += stride)
    for (int x0 = 0; x0 < width; x0 += stride) {
      const int drawn_x = x0 + static_cast<int>(random.below(std::min(stride, width - x0)));
      const int drawn_y = y0 + static_cast<int>(random.below(std::min(stride, height - y0)));
      for (int y = y0; y < std::min(height, y0 + stride); ++y)
        for (int x = x0; x < std::min(width, x0 + stride); ++x) {
          const uint32_t pixel = static_cast<uint32_t>(y) * width + x;
          if (cls[pixel] < 0 || !(near[pixel] || (x == drawn_x && y == drawn_y))) continue;
          chosen.pixels.push_back(pixel);
          chosen.target.push_back(cls[pixel]);
        }
    }
  return chosen;
}

}  // namespace pliant
