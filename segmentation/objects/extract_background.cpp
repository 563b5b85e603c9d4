// What the background gives back to an object that is cut out, and takes from it: contact, enclosed specks, islands,
// hull.

#include <algorithm>
#include <cmath>
#include <map>

#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "segmentation/discover/automatic_supports.h"
#include "segmentation/graph/convex_hull.h"
#include "segmentation/objects/extract_steps.h"

namespace pliant {
namespace {

/// Distance from the contact plane within which a Gaussian may be on either side.
float contact_tolerance(const ContactRegion& contact) { return std::max(2 * contact.thickness, 0.005f * contact.size); }

}  // namespace

std::optional<uint32_t> find_support(const ExtractOptions& options, const GaussianCloud& cloud,
                                     const Segmentation& segmentation, const std::vector<int>& object,
                                     std::vector<int> background) {
  const Vec3f& up = options.up;
  std::erase_if(background, [&](int p) {
    const uint32_t id = segmentation.label[p];
    return id == options.object || (options.supports && std::find(options.supports->begin(), options.supports->end(),
                                                                  id) == options.supports->end());
  });
  if (background.empty() || object.empty()) return std::nullopt;
  std::vector<int> lowest = object;
  std::sort(lowest.begin(), lowest.end(), [&](int a, int b) {
    const float ha = up.dot(cloud.position[a]), hb = up.dot(cloud.position[b]);
    return ha != hb ? ha < hb : a < b;
  });
  lowest.resize(std::max<size_t>(1, lowest.size() / 20));
  const std::vector<int> near = k_nearest(positions(cloud, background), positions(cloud, lowest), 3);
  std::map<uint32_t, size_t> count;
  for (int n : near)
    if (n >= 0) ++count[segmentation.label[background[n]]];
  const auto best =
      std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (best == count.end()) return std::nullopt;
  return best->first;
}

bool stands_on(const ContactRegion& contact, std::span<const Vec3f> object, std::span<const Vec3f> support) {
  constexpr float kAbove = 0.9f;    // share of the object
  constexpr float kDeepest = 0.1f;  // depth of the lowest part below the plane / the object's size
  constexpr float kFoot = 0.1f;     // height of the part about which the plane must go on / the same
  constexpr float kFlat = 0.015f;   // half thickness of the plane / size, as it is fitted
  constexpr float kBeyond = 0.4f;   // of the directions from the foot in which the plane goes on
  if (!contact.found || contact.band_low < -kDeepest * contact.size) return false;
  const float thickness = kFlat * contact.size, top = std::max(contact.band_low, 0.0f) + kFoot * contact.size;
  std::vector<Vec3f> points;
  size_t above = 0;
  for (const Vec3f& x : object) {
    const float h = contact.height(x);
    above += h > -thickness;
    if (h <= top) points.push_back(x);
  }
  if (static_cast<float>(above) < kAbove * static_cast<float>(object.size())) return false;
  std::vector<uint8_t> label(points.size(), 1);
  points.insert(points.end(), support.begin(), support.end());
  label.resize(points.size(), 0);
  Support plane;
  plane.point = contact.point;
  plane.normal = contact.normal;
  plane.tolerance = thickness;
  return share_beyond(plane, points, label) >= kBeyond;
}

void settle_contact(const GaussianCloud& cloud, const Segmentation& segmentation, uint32_t support_id, bool named,
                    float link, const ContactRegion& contact, std::vector<Place>& place, std::vector<ExtractRule>& rule,
                    ExtractSummary& summary) {
  const float tolerance = contact_tolerance(contact), band = 0.1f * contact.size;
  std::vector<int> support, below, above;
  for (int p : indices_of(place, Place::kBackground))
    if (segmentation.label[p] == support_id) support.push_back(p);
  for (size_t p = 0; p < place.size(); ++p) {
    const float h = contact.height(cloud.position[p]);
    if (place[p] == Place::kObject && h < -tolerance && h > -band) below.push_back(static_cast<int>(p));
  }
  // A flat support has nothing above its plane, so there whatever touches the object belongs to it, from neighbour to
  // neighbour; on rough ground only what lies in the middle of the object does.
  const bool flat = named && contact.thickness < 0.01f * contact.size;
  for (int p : support) {
    const float h = contact.height(cloud.position[p]);
    if (h > tolerance && (flat || h < band)) above.push_back(p);
  }
  const std::vector<Vec3f> support_points = positions(cloud, support),
                           all(cloud.position.begin(), cloud.position.end());
  const std::vector<int> nearest = k_nearest(support_points, positions(cloud, below), 1);
  constexpr int kAround = 9;
  const std::vector<int> around = k_nearest(all, positions(cloud, above), kAround);
  const int needed = flat ? 2 : kAround / 2 + 1, rounds = flat ? 100 : 1;
  for (int round = 0; round < rounds; ++round) {
    std::vector<int> to_object;
    for (size_t i = 0; i < above.size(); ++i) {
      int votes = 0;
      for (int j = 0; j < kAround; ++j)
        if (const int n = around[i * kAround + j]; n >= 0) votes += place[n] == Place::kObject;
      if (place[above[i]] == Place::kBackground && votes >= needed) to_object.push_back(above[i]);
    }
    if (to_object.empty()) break;
    for (int p : to_object) {
      place[p] = Place::kObject;
      rule[p] = ExtractRule::kFromSupport;
    }
    summary.contact_to_object += to_object.size();
  }
  for (size_t i = 0; i < below.size(); ++i) {
    if (nearest[i] < 0 || (support_points[nearest[i]] - cloud.position[below[i]]).norm() > 3 * link) continue;
    place[below[i]] = Place::kBackground;
    rule[below[i]] = ExtractRule::kToSupport;
    ++summary.contact_to_support;
  }
}

size_t take_enclosed(const GaussianCloud& cloud, std::vector<Place>& place, std::vector<ExtractRule>& rule) {
  constexpr int kAround = 10, kRounds = 20;  // the nearest one is the Gaussian itself
  const std::vector<int> around = k_nearest(cloud.position, cloud.position, kAround);
  size_t taken = 0;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<size_t> enclosed;
    for (size_t p = 0; p < place.size(); ++p) {
      if (place[p] != Place::kBackground) continue;
      int votes = 0;
      for (int j = 0; j < kAround; ++j)
        if (const int n = around[p * kAround + j]; n >= 0) votes += place[n] == Place::kObject;
      if (2 * votes > kAround) enclosed.push_back(p);
    }
    for (size_t p : enclosed) {
      place[p] = Place::kObject;
      rule[p] = ExtractRule::kEnclosed;
    }
    taken += enclosed.size();
    if (enclosed.empty()) break;
  }
  return taken;
}

size_t take_islands(const GaussianCloud& cloud, const Segmentation& segmentation, uint32_t object_id,
                    const ContactRegion& contact, float link, float share, std::vector<Place>& place,
                    std::vector<ExtractRule>& rule) {
  const std::vector<int> background = indices_of(place, Place::kBackground), object = indices_of(place, Place::kObject);
  const std::vector<int> part = parts_of(cloud, background, link);
  std::vector<size_t> size(part.size(), 0);
  for (int of : part) ++size[of];
  const auto small = [&](size_t i) {
    return static_cast<float>(size[part[i]]) < share * static_cast<float>(object.size());
  };
  std::vector<int> candidates;  // into background
  for (size_t i = 0; i < part.size(); ++i)
    if (small(i)) candidates.push_back(static_cast<int>(i));
  std::vector<int> indices;
  for (int i : candidates) indices.push_back(background[i]);
  const std::vector<int> nearest = k_nearest(positions(cloud, object), positions(cloud, indices), 1);
  struct Island {
    bool touches = false;
    double height = 0;
    std::map<uint32_t, size_t> labels;
  };
  std::map<int, Island> islands;
  for (size_t k = 0; k < indices.size(); ++k) {
    const int p = indices[k], n = nearest[k] < 0 ? -1 : object[nearest[k]];
    Island& island = islands[part[candidates[k]]];
    island.touches = island.touches ||
                     (n >= 0 && (cloud.position[n] - cloud.position[p]).norm() <= touching_distance(cloud, p, n, link));
    island.height += contact.found ? contact.height(cloud.position[p]) : INFINITY;
    ++island.labels[segmentation.label[p]];
  }
  std::map<uint32_t, size_t> of_label;
  for (int p : background) ++of_label[segmentation.label[p]];
  size_t taken = 0;
  for (size_t k = 0; k < indices.size(); ++k) {
    const int root = part[candidates[k]];
    const Island& island = islands[root];
    const auto commonest = std::max_element(island.labels.begin(), island.labels.end(),
                                            [](const auto& a, const auto& b) { return a.second < b.second; });
    const bool itself = commonest->first != object_id && 2 * commonest->second > of_label[commonest->first];
    if (!island.touches || itself || island.height <= size[root] * contact_tolerance(contact)) continue;
    place[indices[k]] = Place::kObject;
    rule[indices[k]] = ExtractRule::kIsland;
    ++taken;
  }
  return taken;
}

size_t take_hull(const GaussianCloud& cloud, const ContactRegion& contact, std::vector<Place>& place,
                 std::vector<ExtractRule>& rule) {
  const std::vector<Vec3f> object = positions(cloud, indices_of(place, Place::kObject));
  const ConvexHull hull(object);
  std::vector<uint8_t> inside(place.size(), 0);
  parallel_for(
      static_cast<std::ptrdiff_t>(place.size()),
      [&](std::ptrdiff_t p) {
        if (place[p] != Place::kBackground ||
            (contact.found && contact.height(cloud.position[p]) <= contact_tolerance(contact)))
          return;
        inside[p] = hull.contains(cloud.position[p]);
      },
      256);
  size_t taken = 0;
  for (size_t p = 0; p < place.size(); ++p)
    if (inside[p]) {
      place[p] = Place::kObject;
      rule[p] = ExtractRule::kHull;
      ++taken;
    }
  return taken;
}

}  // namespace pliant
