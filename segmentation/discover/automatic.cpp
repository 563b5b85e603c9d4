#include "segmentation/discover/automatic.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>

#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

constexpr float kClose = 4;  // spacings between an object and what belongs to it though no edge joins them

/// Nodes that are not of an object, by connected parts, and the object that each part lies near.
struct LooseParts {
  std::vector<int> number;  ///< [S] of every node's part; -1 = of an object
  std::vector<int> near;    ///< object that has a node within `kClose` spacings of the part, the nearest; -1 = none
};

LooseParts loose_parts(const SolidScene& scene, float link, const std::vector<int>& object,
                       const std::function<bool(int object)>& counts) {
  std::vector<uint8_t> loose(scene.size());
  std::vector<int> body, others;
  for (size_t i = 0; i < scene.size(); ++i) {
    loose[i] = !counts(object[i]);
    (loose[i] ? others : body).push_back(static_cast<int>(i));
  }
  LooseParts parts{connected_parts(scene.graph, loose, link, true), {}};
  const auto at = [&](const std::vector<int>& nodes) {
    std::vector<Vec3f> points;
    for (const int i : nodes) points.push_back(scene.cloud.position[i]);
    return points;
  };
  const std::vector<Vec3f> bodies = at(body), points = at(others);
  const std::vector<int> nearest = k_nearest(bodies, points, 1);
  parts.near.assign(others.empty() ? 0 : 1 + *std::max_element(parts.number.begin(), parts.number.end()), -1);
  std::vector<float> least(parts.near.size(), kClose * scene.graph.spacing);
  for (size_t k = 0; k < others.size(); ++k) {
    if (nearest[k] < 0) continue;
    const int part = parts.number[others[k]];
    const float distance = (bodies[nearest[k]] - points[k]).norm();
    if (distance > least[part]) continue;
    least[part] = distance;
    parts.near[part] = object[body[nearest[k]]];
  }
  return parts;
}

/// Whether a scene without a support is the largest object alone.  All else lies within it or near it, but for specks,
/// and other objects near it; or much is left as rest, and all of it lies within.
bool is_one_thing(const PartOptions& options, const SolidScene& scene, const SceneParts& parts) {
  constexpr double kMuch = 0.1, kWithin = 0.95;  // of what the views show; of what is not the largest object
  constexpr double kSpecks = 0.01;               // of what the views show
  constexpr float kMargin = 0.05f;               // of the largest object's size, on every side
  const LooseParts loose = loose_parts(scene, options.link, parts.object, [](int object) { return object == 0; });
  Box bounds;
  for (size_t i = 0; i < scene.size(); ++i)
    if (parts.object[i] == 0) bounds.add(scene.cloud.position[i]);
  const Vec3f margin = kMargin * bounds.size();
  bounds = {bounds.low - margin, bounds.high + margin};
  double all = 0, rest = 0, others = 0, within = 0, apart = 0;
  bool near = true;
  for (size_t i = 0; i < scene.size(); ++i) {
    all += scene.mass[i];
    if (parts.object[i] == 0) continue;
    const bool inside = bounds.contains(scene.cloud.position[i]), joined = loose.near[loose.number[i]] == 0;
    others += scene.mass[i];
    if (parts.object[i] == SceneParts::kRest) rest += scene.mass[i];
    if (inside) within += scene.mass[i];
    if (!inside && !joined) apart += scene.mass[i];
    near = near && (joined || parts.object[i] == SceneParts::kRest);
  }
  return (near && apart <= kSpecks * all) || (rest >= kMuch * all && within >= kWithin * others);
}

/// Without a support, nothing but the objects holds what is left as rest: a splat of one thing alone is whole, and
/// near an object the rest belongs to it.
void join_rest(const PartOptions& options, const SolidScene& scene, const std::vector<Support>& supports,
               SceneParts& parts) {
  if (!supports.empty() || parts.objects.empty()) return;
  if (is_one_thing(options, scene, parts)) {
    SceneParts::Part& one = parts.objects[0];
    one.share = std::accumulate(scene.mass.begin(), scene.mass.end(), 0.0);
    one.nodes.resize(scene.size());
    std::iota(one.nodes.begin(), one.nodes.end(), 0);
    parts.objects.resize(1);
    std::fill(parts.object.begin(), parts.object.end(), 0);
    return;
  }
  const LooseParts loose = loose_parts(scene, options.link, parts.object, [](int object) { return object >= 0; });
  for (size_t i = 0; i < scene.size(); ++i)
    if (const int part = loose.number[i]; part >= 0 && loose.near[part] >= 0) parts.object[i] = loose.near[part];
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
  join_rest(options.part, scene, supports, parts);

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

  // Haze takes the label of the nearest surface, if one is near or there is only one thing.
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
  const bool alone = std::all_of(parts.object.begin(), parts.object.end(), [](int object) { return object == 0; });
  const auto reach = [&](int p) {
    return alone ? INFINITY : std::max(options.haze * scene.graph.spacing, 2 * std::exp(cloud.log_scale[p].maxCoeff()));
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
