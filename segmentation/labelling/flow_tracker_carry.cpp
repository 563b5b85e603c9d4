// How masks move on to the next picture.

#include <algorithm>
#include <cmath>

#include "gaussians/base/quantile.h"
#include "gaussians/vision/optical_flow.h"
#include "segmentation/labelling/flow_tracker.h"

namespace pliant {
namespace {

float square(float x) { return x * x; }

}  // namespace

std::optional<FlowTracker::Carried> FlowTracker::carry_by_flow(const Flows& flows, const ImageF& lab_before,
                                                               const Thing& thing) const {
  const int width = picture_.width, height = picture_.height;
  Carried carried{ImageF(width, height, 1, kOut), ImageF(width, height, 1, options_.doubt), 0};
  size_t inside = 0, believed = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float u = x + 0.5f + flows.back(x, y, 0), v = y + 0.5f + flows.back(x, y, 1);
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      const float du = flows.back(x, y, 0) + sample(flows.forth, u, v, 0),
                  dv = flows.back(x, y, 1) + sample(flows.forth, u, v, 1);
      const bool sure = std::hypot(du, dv) <= options_.consistent;
      carried.mask(x, y) = std::clamp(sample(thing.mask, u, v, 0), -1.0f, 1.0f);
      if (sure) carried.trust(x, y) = 1;
      if (carried.mask(x, y) <= 0) continue;
      ++inside;
      believed += sure;
      for (int c = 0; c < 3; ++c) carried.misfit += square(lab_(x, y, c) - sample(lab_before, u, v, c));
    }
  carried.misfit /= static_cast<float>(std::max<size_t>(1, inside));
  if (static_cast<float>(believed) < options_.least_believed * static_cast<float>(inside)) return std::nullopt;
  return carried;
}

/// The whole pixels by which the mask's colours move, when they fit much better there than elsewhere.
std::optional<FlowTracker::Carried> FlowTracker::carry_by_shift(const ImageF& lab_before, const Thing& thing) const {
  constexpr size_t kSamples = 400;
  constexpr float kInside = 0.3f;  // of the samples must lie in the picture
  constexpr float kFits = 4;       // times the mean square, up to which a pixel is believed
  const int width = picture_.width, height = picture_.height;
  std::vector<Eigen::Vector2i> pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (thing.mask(x, y) > 0) pixels.emplace_back(x, y);
  if (pixels.empty()) return std::nullopt;
  const int reach = std::clamp(static_cast<int>(options_.reach * std::sqrt(static_cast<float>(pixels.size()))), 8, 48);
  const size_t step = std::max<size_t>(1, pixels.size() / kSamples);
  const auto color = [](const ImageF& lab, int x, int y) { return Eigen::Map<const Vec3f>(lab.at(x, y)); };
  std::vector<float> costs;
  float least = INFINITY;
  Eigen::Vector2i shift(0, 0);
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      float sum = 0;
      size_t inside = 0, looked = 0;
      for (size_t k = 0; k < pixels.size(); k += step, ++looked) {
        const int x = pixels[k].x() + dx, y = pixels[k].y() + dy;
        if (x < 0 || y < 0 || x >= width || y >= height) continue;
        sum += (color(lab_, x, y) - color(lab_before, pixels[k].x(), pixels[k].y())).squaredNorm();
        ++inside;
      }
      if (static_cast<float>(inside) < kInside * static_cast<float>(looked)) continue;
      costs.push_back(sum / static_cast<float>(inside));
      if (costs.back() < least) {
        least = costs.back();
        shift = {dx, dy};
      }
    }
  if (costs.empty()) return std::nullopt;
  if (least > options_.stands_out * quantile(costs, 0.5)) return std::nullopt;
  Carried carried{ImageF(width, height, 1, kOut), ImageF(width, height, 1, options_.doubt), least};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int u = x - shift.x(), v = y - shift.y();
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      carried.mask(x, y) = std::clamp(thing.mask(u, v), -1.0f, 1.0f);
      if ((color(lab_, x, y) - color(lab_before, u, v)).squaredNorm() <= kFits * least) carried.trust(x, y) = 1;
    }
  return carried;
}

}  // namespace pliant
