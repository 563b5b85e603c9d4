#include "segmentation/discover/automatic_parts.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Part = SceneParts::Part;

Part part_of(const SolidScene& scene, std::vector<int> nodes) {
  Part part;
  part.nodes = std::move(nodes);
  std::sort(part.nodes.begin(), part.nodes.end());
  for (int i : part.nodes) part.share += scene.mass[i];
  return part;
}

bool shows_enough(const PartOptions& options, const Part& part) {
  return part.share >= options.least_share && static_cast<int>(part.nodes.size()) >= options.least_gaussians;
}

/// First support that the part comes close to, -1 for none.
int support_of(const PartOptions& options, const SolidScene& scene, const std::vector<Support>& supports,
               const Part& part) {
  for (size_t k = 0; k < supports.size(); ++k) {
    float low = INFINITY, high = -INFINITY;
    for (int i : part.nodes) {
      const float h = supports[k].height(scene.cloud.position[i]);
      low = std::min(low, h);
      high = std::max(high, h);
    }
    if (low <= supports[k].tolerance + options.reach * (high - low)) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace

SceneParts scene_parts(const PartOptions& options, const SolidScene& scene, const std::vector<Support>& supports) {
  const size_t n = scene.size();
  SceneParts out;
  out.object.assign(n, SceneParts::kRest);
  std::vector<uint8_t> standing(n, 1), on_ground(n, 0);
  for (size_t i = 0; i < n; ++i)
    for (size_t k = 0; k < supports.size() && standing[i]; ++k) {
      const float above = supports[k].height(scene.cloud.position[i]) - supports[k].tolerance;
      on_ground[i] |= (k == 0 && above <= 2 * scene.graph.spacing);
      if (above <= 0) {
        standing[i] = 0;
        out.object[i] = SceneParts::kRest - 1 - static_cast<int>(k);
      }
    }

  const std::vector<int> number = connected_parts(scene.graph, standing, options.link, true);
  std::vector<std::vector<int>> connected(1 + (n > 0 ? *std::max_element(number.begin(), number.end()) : -1));
  for (size_t i = 0; i < n; ++i)
    if (number[i] >= 0) connected[number[i]].push_back(static_cast<int>(i));

  for (std::vector<int>& nodes : connected) {
    Part whole = part_of(scene, std::move(nodes));
    if (!shows_enough(options, whole)) continue;
    whole.support = support_of(options, scene, supports, whole);
    if (whole.support < 0 && !supports.empty()) continue;
    const std::vector<int> group = split_things(options.split, scene, whole.nodes, on_ground);
    std::vector<std::vector<int>> things(1 + *std::max_element(group.begin(), group.end()));
    for (size_t k = 0; k < group.size(); ++k) things[group[k]].push_back(whole.nodes[k]);
    for (std::vector<int>& members : things) {
      Part thing = part_of(scene, std::move(members));
      if (!shows_enough(options, thing)) continue;
      thing.support = whole.support;
      thing.parted = things.size() > 1;
      out.objects.push_back(std::move(thing));
    }
  }
  std::stable_sort(out.objects.begin(), out.objects.end(),
                   [](const Part& a, const Part& b) { return a.share > b.share; });
  for (size_t k = 0; k < out.objects.size(); ++k)
    for (int i : out.objects[k].nodes) out.object[i] = static_cast<int>(k);
  return out;
}

}  // namespace pliant
