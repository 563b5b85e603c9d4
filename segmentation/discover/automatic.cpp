#include "segmentation/discover/automatic.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "gaussians/base/portable.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

/// A splat of one thing alone, part of which no view joins to it: without a support, much is left as rest, and all of
/// it lies within the largest object.  Then everything is that object.
void join_one_thing(const SolidScene& scene, const std::vector<Support>& supports, SceneParts& parts) {
  constexpr double kMuch = 0.1, kWithin = 0.95;  // of what the views show; of what is not the largest object
  constexpr float kMargin = 0.05f;               // of its size, on every side
  if (!supports.empty() || parts.objects.empty()) return;
  Box bounds;
  double all = 0, rest = 0, others = 0, within = 0;
  for (size_t i = 0; i < scene.size(); ++i) {
    if (parts.object[i] == 0) bounds.add(scene.cloud.position[i]);
    all += scene.mass[i];
    if (parts.object[i] == SceneParts::kRest) rest += scene.mass[i];
  }
  const Vec3f margin = kMargin * bounds.size();
  bounds = {bounds.low - margin, bounds.high + margin};
  for (size_t i = 0; i < scene.size(); ++i) {
    if (parts.object[i] == 0) continue;
    others += scene.mass[i];
    if (bounds.contains(scene.cloud.position[i])) within += scene.mass[i];
  }
  if (rest < kMuch * all || within < kWithin * others) return;
  SceneParts::Part& one = parts.objects[0];
  for (size_t k = 1; k < parts.objects.size(); ++k) one.share += parts.objects[k].share;
  one.share += rest;
  one.nodes.resize(scene.size());
  std::iota(one.nodes.begin(), one.nodes.end(), 0);
  parts.objects.resize(1);
  std::fill(parts.object.begin(), parts.object.end(), 0);
}

std::string how_found(const SceneParts::Part& part) {
  const std::string how = part.support < 0 ? "stands free" : "stands on support_" + std::to_string(part.support + 1);
  return part.parted ? how + ", separated from what it touches by color and edges" : how;
}

}  // namespace

std::string AutomaticSummary::describe() const {
  char text[256];
  std::snprintf(text, sizeof text,
                "%d free-standing objects and %d supports from %zu solid Gaussians in %d views, %.0f %% of the visible "
                "area is left as rest",
                objects, supports, solid, views, 100 * rest);
  return text;
}

AutomaticResult find_objects(const AutomaticOptions& options, const GaussianCloud& cloud,
                             const std::vector<Camera>& cameras) {
  const auto start = std::chrono::steady_clock::now();
  const auto since = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const SolidScene scene = solid_scene(options.solid, cloud, cameras, options.held_out);
  const std::vector<Support> supports = find_supports(options.support, scene, options.up);
  SceneParts parts = scene_parts(options.part, scene, supports);
  join_one_thing(scene, supports, parts);

  AutomaticResult out;
  uint32_t id = 0;
  for (const SceneParts::Part& part : parts.objects)
    out.found.push_back({++id, "object_" + std::to_string(id), FoundThing::Kind::kObject, how_found(part), part.share});
  const uint32_t first_support = id + 1;
  for (size_t k = 0; k < supports.size(); ++k)
    out.found.push_back({++id, "support_" + std::to_string(k + 1), FoundThing::Kind::kSupport,
                         supports[k].wall ? "upright plane with everything on one side" : "plane below everything",
                         0.0});
  const uint32_t rest = ++id;
  out.found.push_back({rest, "rest", FoundThing::Kind::kRest, "neither object nor support", 0.0});

  // Haze takes the label of the nearest surface, if one is near.
  std::vector<uint8_t> solid(cloud.size(), 0);
  out.label.assign(cloud.size(), rest);
  double total = 0;
  for (size_t i = 0; i < scene.size(); ++i) {
    const int at = parts.object[i];
    const uint32_t mine = at >= 0                   ? at + 1
                          : at == SceneParts::kRest ? rest
                                                    : first_support + (SceneParts::kRest - 1 - at);
    solid[scene.gaussian[i]] = 1;
    out.label[scene.gaussian[i]] = mine;
    total += scene.mass[i];
    if (at < 0) out.found[mine - 1].share += scene.mass[i];
  }
  std::vector<int> finite;
  std::vector<Vec3f> position;
  std::vector<uint8_t> seen;
  for (size_t p = 0; p < cloud.size(); ++p)
    if (cloud.position[p].allFinite()) {
      finite.push_back(static_cast<int>(p));
      position.push_back(cloud.position[p]);
      seen.push_back(solid[p]);
    }
  const std::vector<int> source = nearest_seen(position, seen);
  const auto reach = [&](int p) {
    return std::max(options.haze * scene.graph.spacing, 2 * std::exp(cloud.log_scale[p].maxCoeff()));
  };
  for (size_t k = 0; k < finite.size(); ++k)
    if (source[k] >= 0 && (position[source[k]] - position[k]).norm() <= reach(finite[k]))
      out.label[finite[k]] = out.label[finite[source[k]]];

  out.summary = {scene.size(),
                 scene.views,
                 static_cast<int>(parts.objects.size()),
                 static_cast<int>(supports.size()),
                 total > 0 ? out.found.back().share / total : 0.0,
                 since()};
  return out;
}

}  // namespace pliant
