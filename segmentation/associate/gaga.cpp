#include "segmentation/associate/gaga.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>

#include "segmentation/associate/footprint.h"
#include "segmentation/associate/id_tally.h"

namespace pliant {
namespace {

/// A centre that projects into a mask.
struct Centre {
  int mask, patch;
  float depth;
  int gaussian;
};

/// Front centres of every mask of a view, `mask` [pixels] as of masks_of_pixels.
std::vector<std::vector<int>> front_centres(const GagaOptions& options, const GaussianCloud& cloud,
                                            const Camera& camera, const std::vector<int>& mask, size_t masks) {
  std::vector<Centre> centres;
  for (size_t p = 0; p < cloud.size(); ++p) {
    const Vec3d x = camera.cam_from_world * cloud.position[p].cast<double>();
    if (x.z() <= 0) continue;
    const double u = std::floor(camera.fx * x.x() / x.z() + camera.cx),
                 v = std::floor(camera.fy * x.y() / x.z() + camera.cy);
    if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) continue;
    const int px = static_cast<int>(u), py = static_cast<int>(v);
    const int m = mask[static_cast<size_t>(py) * camera.width + px];
    if (m < 0) continue;
    const int patch = py * options.patches / camera.height * options.patches + px * options.patches / camera.width;
    centres.push_back({m, patch, static_cast<float>(x.z()), static_cast<int>(p)});
  }
  std::sort(centres.begin(), centres.end(), [](const Centre& a, const Centre& b) {
    return std::tie(a.mask, a.patch, a.depth, a.gaussian) < std::tie(b.mask, b.patch, b.depth, b.gaussian);
  });
  std::vector<std::vector<int>> front(masks);
  for (size_t begin = 0, end = 0; begin < centres.size(); begin = end) {
    while (end < centres.size() && centres[end].mask == centres[begin].mask &&
           centres[end].patch == centres[begin].patch)
      ++end;
    const size_t kept = std::max<size_t>(1, static_cast<size_t>(options.front * static_cast<float>(end - begin)));
    for (size_t i = begin; i < begin + kept; ++i) front[centres[i].mask].push_back(centres[i].gaussian);
  }
  return front;
}

/// The group that a mask on these Gaussians joins; -1 = none.  `owner`: group of every Gaussian, -1 = none.
int best_group(const GagaOptions& options, const std::vector<int>& on, const std::vector<int>& owner) {
  std::map<int, int> common;
  for (const int p : on)
    if (owner[p] >= 0) ++common[owner[p]];
  int best = -1;
  double highest = 0;
  for (const auto& [group, count] : common) {
    const double score = static_cast<double>(count) / (static_cast<double>(on.size()) + count);
    if (score < options.overlap || score <= highest) continue;
    highest = score;
    best = group;
  }
  return best;
}

}  // namespace

GagaResult associate_by_centres(const GagaOptions& options, const GaussianCloud& cloud,
                                const std::vector<Camera>& cameras, const MaskSet& masks) {
  GagaResult result;
  result.masks.warnings = masks.warnings;
  std::vector<int> owner(cloud.size(), -1);
  std::vector<size_t> order = used_views(options.held_out, cameras, masks);
  std::vector<MaskSet::View> relabelled(masks.views.size());
  struct Assigned {
    int group = -1;  ///< -1 = none
    uint32_t id = 0;
    int pixels = 0;
  };
  std::vector<Assigned> assigned;  // masks of all views
  for (const size_t v : order) {
    if (options.under_way) options.under_way();
    const MaskSet::View& in = masks.views[v];
    std::vector<uint32_t> id;
    const std::vector<int> mask = masks_of_pixels(in.ids, id);
    const std::vector<std::vector<int>> front = front_centres(options, cloud, cameras[in.camera], mask, id.size());
    std::vector<Assigned> here(id.size());
    for (size_t m = 0; m < id.size(); ++m) {
      here[m].id = id[m];
      if (front[m].empty()) continue;
      int group = best_group(options, front[m], owner);
      if (group < 0) group = result.summary.groups++;
      for (const int p : front[m])
        if (owner[p] < 0) owner[p] = group;
      here[m].group = group;
    }
    relabelled[v] = {in.camera, IdImage(in.ids.width, in.ids.height, 1)};
    for (size_t pixel = 0; pixel < mask.size(); ++pixel)
      if (mask[pixel] >= 0) {
        relabelled[v].ids.data[pixel] = static_cast<uint32_t>(here[mask[pixel]].group + 1);
        ++here[mask[pixel]].pixels;
      }
    assigned.insert(assigned.end(), here.begin(), here.end());
    result.summary.masks += static_cast<int>(id.size());
  }
  IdTally tally(result.summary.groups);
  for (const Assigned& mask : assigned) tally.add(mask.group, mask.id, mask.pixels);
  const std::vector<uint32_t> kept = tally.kept();
  for (size_t g = 0; g < kept.size(); ++g)
    if (const auto name = masks.names.find(kept[g]); name != masks.names.end())
      result.masks.names[static_cast<uint32_t>(g) + 1] = name->second;
  result.summary.views = static_cast<int>(order.size());
  std::sort(order.begin(), order.end());
  for (const size_t v : order) result.masks.views.push_back(std::move(relabelled[v]));
  return result;
}

std::string GagaSummary::describe() const {
  char text[200];
  std::snprintf(text, sizeof(text), "%d masks in %d views belong to %d groups by Gaga's rule", masks, views, groups);
  return text;
}

}  // namespace pliant
