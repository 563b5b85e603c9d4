#include "segmentation/discover/automatic.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <numeric>

#include "gaussians/base/portable.h"
#include "segmentation/labels/spread.h"

namespace pliant {
namespace {

/// Ids of a view: the id with most blend weight at every pixel.
IdImage ids_of_view(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& render,
                    const std::vector<uint32_t>& label) {
  constexpr float kOpaque = 0.5f;
  const BlendWeights weights = blend_weights(cloud, camera, render);
  IdImage ids(camera.width, camera.height, 1);
  const uint32_t most = label.empty() ? 0 : *std::max_element(label.begin(), label.end());
  parallel_for(
      camera.height,
      [&](std::ptrdiff_t y) {
        std::vector<float> sum(most + 1);
        for (int x = 0; x < camera.width; ++x) {
          const size_t pixel = static_cast<size_t>(y) * camera.width + x;
          std::fill(sum.begin(), sum.end(), 0.0f);
          float alpha = 0;
          for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
            sum[label[weights.gaussian[e]]] += weights.weight[e];
            alpha += weights.weight[e];
          }
          if (alpha >= kOpaque)
            ids.data[pixel] = static_cast<uint32_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
        }
      },
      4);
  return ids;
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
  const SceneParts parts = scene_parts(options.part, scene, supports);

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

  // Haze takes the label of the nearest surface.
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
  for (size_t k = 0; k < finite.size(); ++k)
    if (source[k] >= 0) out.label[finite[k]] = out.label[finite[source[k]]];

  for (const FoundThing& thing : out.found) out.masks.names[thing.id] = thing.name;
  for (int c = 0; c < static_cast<int>(cameras.size()); ++c)
    if (std::find(options.held_out.begin(), options.held_out.end(), c) == options.held_out.end())
      out.masks.views.push_back({c, ids_of_view(cloud, cameras[c], options.solid.footprint.render, out.label)});
  out.summary = {scene.size(),
                 scene.views,
                 static_cast<int>(parts.objects.size()),
                 static_cast<int>(supports.size()),
                 total > 0 ? out.found.back().share / total : 0.0,
                 since()};
  return out;
}

}  // namespace pliant
