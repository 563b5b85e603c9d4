#include "segmentation/lift/automatic_parts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace pliant {

SceneParts scene_parts(const PartOptions& options, const SolidScene& scene, const std::vector<Support>& supports) {
  const size_t n = scene.size();
  SceneParts out;
  out.object.assign(n, SceneParts::kRest);
  std::vector<uint8_t> standing(n, 1);
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < supports.size() && standing[i]; ++k)
      if (supports[k].height(scene.cloud.position[i]) <= supports[k].tolerance)
        standing[i] = 0, out.object[i] = SceneParts::kRest - 1 - static_cast<int>(k);
  const std::vector<int> part = connected_parts(scene.graph, standing, options.link, true);
  const int parts = n > 0 ? *std::max_element(part.begin(), part.end()) + 1 : 0;

  struct Found {
    std::vector<int> nodes;
    double share = 0;
  };
  std::vector<Found> found(parts);
  for (size_t i = 0; i < n; ++i)
    if (part[i] >= 0) found[part[i]].nodes.push_back(static_cast<int>(i)), found[part[i]].share += scene.mass[i];
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.share > b.share; });
  for (const Found& f : found) {
    if (f.share < options.least_share || static_cast<int>(f.nodes.size()) < options.least_gaussians) continue;
    int on = -1;
    for (size_t k = 0; k < supports.size() && on < 0; ++k) {
      float low = INFINITY, high = -INFINITY;
      for (int i : f.nodes) {
        const float h = supports[k].height(scene.cloud.position[i]);
        low = std::min(low, h), high = std::max(high, h);
      }
      if (low <= supports[k].tolerance + options.reach * (high - low)) on = static_cast<int>(k);
    }
    if (on < 0 && !supports.empty()) continue;
    for (int i : f.nodes) out.object[i] = static_cast<int>(out.objects.size());
    out.objects.push_back({f.nodes.size(), f.share, on});
  }
  return out;
}

}  // namespace pliant
