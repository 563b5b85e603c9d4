#include "segmentation/discover/automatic_parts.h"

#include <algorithm>
#include <cmath>
#include <map>

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

/// Nodes of every part, ascending, from the number of every node's part; -1 belongs to none.
std::vector<std::vector<int>> nodes_of_parts(const std::vector<int>& number) {
  std::vector<std::vector<int>> parts(number.empty() ? 0 : 1 + *std::max_element(number.begin(), number.end()));
  for (size_t i = 0; i < number.size(); ++i)
    if (number[i] >= 0) parts[number[i]].push_back(static_cast<int>(i));
  return parts;
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

/// Connected Gaussians of the rest that show too little to be an object belong to what most of them lie against.
void give_crumbs_away(const PartOptions& options, const SolidScene& scene, std::vector<int>& object) {
  std::vector<uint8_t> rest(scene.size());
  for (size_t i = 0; i < scene.size(); ++i) rest[i] = object[i] == SceneParts::kRest;
  const std::vector<std::vector<int>> parts = nodes_of_parts(connected_parts(scene.graph, rest, options.link, true));
  std::vector<int> part(scene.size(), -1);
  for (size_t k = 0; k < parts.size(); ++k)
    if (!shows_enough(options, part_of(scene, parts[k])))
      for (int i : parts[k]) part[i] = static_cast<int>(k);
  std::vector<std::map<int, double>> against(parts.size());  // nearness by object
  for (size_t e = 0; e < scene.graph.edges.size(); ++e) {
    const double nearness = scene.graph.edge_nearness[e];
    if (nearness <= options.link) continue;
    const auto& [a, b, weight] = scene.graph.edges[e];
    if (part[a] >= 0 && !rest[b]) against[part[a]][object[b]] += nearness;
    if (part[b] >= 0 && !rest[a]) against[part[b]][object[a]] += nearness;
  }
  for (size_t k = 0; k < parts.size(); ++k) {
    if (against[k].empty()) continue;
    const int most = std::max_element(against[k].begin(), against[k].end(), [](const auto& a, const auto& b) {
                       return a.second < b.second;
                     })->first;
    for (int i : parts[k]) object[i] = most;
  }
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

  for (std::vector<int>& nodes : nodes_of_parts(connected_parts(scene.graph, standing, options.link, true))) {
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
  give_crumbs_away(options, scene, out.object);
  return out;
}

}  // namespace pliant
