#include "segmentation/select/superpixels.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr uint16_t kNone = UINT16_MAX;

struct Step {
  float far;
  uint32_t order;  // of equals the one that was found first
  int pixel;
  uint16_t region;

  bool operator<(const Step& other) const { return far != other.far ? far > other.far : order > other.order; }
};

struct Region {
  Vec3f lab = Vec3f::Zero();
  float x = 0, y = 0, count = 0;
};

}  // namespace

std::vector<uint16_t> superpixels(int width, int height, std::span<const Vec3f> lab, float area, float color) {
  CHECK(lab.size() == static_cast<size_t>(width) * height && area >= 1 && color > 0);
  const int columns = std::max(1, static_cast<int>(std::lround(width / std::sqrt(area)))),
            rows = std::max(1, static_cast<int>(std::lround(height / std::sqrt(area))));
  CHECK_MSG(static_cast<size_t>(columns) * rows < kNone, "too many regions in a picture");
  const float place_factor = 1 / area, color_factor = 1 / (color * color);
  std::vector<uint16_t> label(lab.size(), kNone);
  std::vector<Region> regions;
  std::priority_queue<Step> open;
  uint32_t steps = 0;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int x = static_cast<int>((i + 0.5f) * width / columns), y = static_cast<int>((j + 0.5f) * height / rows);
      open.push({0, steps++, y * width + x, static_cast<uint16_t>(regions.size())});
      regions.emplace_back();
    }
  while (!open.empty()) {
    const Step step = open.top();
    open.pop();
    if (label[step.pixel] != kNone) continue;
    label[step.pixel] = step.region;
    Region& region = regions[step.region];
    const int x = step.pixel % width, y = step.pixel / width;
    region.lab += lab[step.pixel];
    region.x += static_cast<float>(x);
    region.y += static_cast<float>(y);
    region.count += 1;
    const Vec3f mean = region.lab / region.count;
    const float middle_x = region.x / region.count, middle_y = region.y / region.count;
    constexpr int kStep[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& [dx, dy] : kStep) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= width || v >= height || label[v * width + u] != kNone) continue;
      const float du = static_cast<float>(u) - middle_x, dv = static_cast<float>(v) - middle_y;
      const float far = place_factor * (du * du + dv * dv) + color_factor * (lab[v * width + u] - mean).squaredNorm();
      open.push({far, steps++, v * width + u, step.region});
    }
  }
  return label;
}

}  // namespace pliant
