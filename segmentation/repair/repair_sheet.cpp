#include <algorithm>
#include <numeric>

#include "segmentation/repair/chosen_views.h"
#include "segmentation/repair/repair.h"

namespace pliant {

ImageF repair_sheet(const RepairResult& result, const GaussianCloud& background, const GaussianCloud& removed,
                    const std::vector<Camera>& cameras, const RenderOptions& render_options) {
  const RepairSummary& summary = result.summary;
  std::vector<size_t> order(summary.hole_before.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return summary.hole_before[a] > summary.hole_before[b]; });
  // The largest hole, then views spread over the rest so that the sides of the hole are shown too.
  std::vector<size_t> chosen;
  for (size_t k = 0; k < 4 && k < order.size(); ++k)
    chosen.push_back(order[k * order.size() / std::min<size_t>(4, order.size())]);
  if (chosen.empty()) return ImageF(1, 1, 3);
  GaussianCloud scene = background;
  scene.append(removed);
  constexpr int kGap = 6;
  const int side = RepairOptions().longest_side;
  const Camera first = scaled_down(cameras[summary.views[chosen[0]]], side);
  ImageF sheet(3 * (first.width + kGap) + kGap, static_cast<int>(chosen.size()) * (first.height + kGap) + kGap, 3,
               0.1f);
  for (size_t row = 0; row < chosen.size(); ++row) {
    Camera camera = scaled_down(cameras[summary.views[chosen[row]]], side);
    if (camera.width != first.width || camera.height != first.height)
      camera = camera.scaled(
          std::min(static_cast<double>(first.width) / camera.width, static_cast<double>(first.height) / camera.height));
    const GaussianCloud* clouds[3] = {&scene, &background, &result.background};
    for (int column = 0; column < 3; ++column) {
      const ImageF picture = render(*clouds[column], camera, render_options).color;
      for (int y = 0; y < std::min(picture.height, first.height); ++y)
        std::copy_n(
            picture.at(0, y), 3 * std::min(picture.width, first.width),
            sheet.at(kGap + column * (first.width + kGap), kGap + static_cast<int>(row) * (first.height + kGap) + y));
    }
  }
  return sheet;
}

}  // namespace pliant
