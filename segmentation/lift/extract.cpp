#include "segmentation/lift/extract.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "segmentation/lift/convex_hull.h"

namespace pliant {
namespace {

enum class Place : uint8_t { kBackground, kObject, kDropped };

/// Standard deviation along the longest axis.
float extent(const GaussianCloud& cloud, int p) { return std::exp(cloud.log_scale[p].maxCoeff()); }

std::vector<Vec3f> positions(const GaussianCloud& cloud, const std::vector<int>& indices) {
  std::vector<Vec3f> points(indices.size());
  for (size_t i = 0; i < indices.size(); ++i) points[i] = cloud.position[indices[i]];
  return points;
}

/// k nearest others of every point, [points, k], -1 where there are fewer.
std::vector<int> neighbours_of(const std::vector<Vec3f>& points, int k) {
  const std::vector<int> with_self = k_nearest(points, points, k + 1);
  std::vector<int> out(points.size() * k, -1);
  for (size_t i = 0; i < points.size(); ++i) {
    int found = 0;
    for (int j = 0; j <= k && found < k; ++j)
      if (const int other = with_self[i * (k + 1) + j]; other >= 0 && other != static_cast<int>(i)) out[i * k + found++] = other;
  }
  return out;
}

float median(std::vector<float> values) {
  if (values.empty()) return 0;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Statistical outlier removal: marks points whose mean neighbour distance exceeds mean + sigma * deviation and whose
/// own extent does not bridge that distance.  Returns the median of the mean distances.
float mark_outliers(const GaussianCloud& cloud, const std::vector<int>& members, int k, float sigma,
                    std::vector<uint8_t>& outlier) {
  const std::vector<Vec3f> points = positions(cloud, members);
  const std::vector<int> near = neighbours_of(points, k);
  std::vector<float> distance(points.size(), 0.0f);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    int count = 0;
    for (int j = 0; j < k; ++j)
      if (const int n = near[i * k + j]; n >= 0) distance[i] += (points[n] - points[i]).norm(), ++count;
    if (count) distance[i] /= static_cast<float>(count);
    sum += distance[i], squares += double(distance[i]) * distance[i];
  }
  const double mean = sum / points.size(), deviation = std::sqrt(std::max(0.0, squares / points.size() - mean * mean));
  outlier.assign(points.size(), 0);
  for (size_t i = 0; i < points.size(); ++i)
    outlier[i] = distance[i] > mean + sigma * deviation && distance[i] > 3 * extent(cloud, members[i]);
  return median(distance);
}

/// Parts connected by neighbours closer than `link` or than their own extents; marks those smaller than `share` of
/// the largest.
void mark_floaters(const GaussianCloud& cloud, const std::vector<int>& members, float link, float share,
                   std::vector<uint8_t>& floater) {
  constexpr int kNeighbours = 10;
  const std::vector<Vec3f> points = positions(cloud, members);
  const std::vector<int> near = neighbours_of(points, kNeighbours);
  std::vector<int> parent(points.size());
  std::iota(parent.begin(), parent.end(), 0);
  auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    for (int j = 0; j < kNeighbours; ++j) {
      const int n = near[static_cast<size_t>(i) * kNeighbours + j];
      if (n < 0) continue;
      const float reach = std::max(link, 2 * (extent(cloud, members[i]) + extent(cloud, members[n])));
      if ((points[n] - points[i]).norm() <= reach) parent[root(i)] = root(n);
    }
  std::vector<size_t> size(points.size(), 0);
  for (int i = 0; i < static_cast<int>(points.size()); ++i) ++size[root(i)];
  const size_t largest = size.empty() ? 0 : *std::max_element(size.begin(), size.end());
  floater.assign(points.size(), 0);
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    floater[i] = static_cast<float>(size[root(i)]) < share * static_cast<float>(largest);
}

std::vector<int> indices_of(const std::vector<Place>& place, Place which) {
  std::vector<int> out;
  for (size_t p = 0; p < place.size(); ++p)
    if (place[p] == which) out.push_back(static_cast<int>(p));
  return out;
}

/// The commonest other id among the Gaussians nearest to the object's lowest twentieth.
uint32_t find_support(const GaussianCloud& cloud, const Segmentation& segmentation, const std::vector<int>& object,
                      const std::vector<int>& background, const Vec3f& up) {
  if (background.empty() || object.empty()) return 0;
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
  const auto best = std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == count.end() ? 0 : best->first;
}

/// Distance from the contact plane within which a Gaussian may be on either side.
float contact_tolerance(const ContactRegion& contact) { return std::max(2 * contact.thickness, 0.005f * contact.size); }

/// Settles Gaussians near the contact plane: the object's below it go to the support where the support is close, the
/// support's above it that lie among the object's go to the object.
/// A support that the scene names is a surface; one that was only found may be the rest of the world.
void settle_contact(const GaussianCloud& cloud, const Segmentation& segmentation, uint32_t support_id, bool named, float link,
                    const ContactRegion& contact, std::vector<Place>& place, std::vector<ExtractRule>& rule, ExtractSummary& summary) {
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
  const std::vector<Vec3f> support_points = positions(cloud, support), all(cloud.position.begin(), cloud.position.end());
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
    for (int p : to_object) place[p] = Place::kObject, rule[p] = ExtractRule::kFromSupport;
    summary.contact_to_object += to_object.size();
  }
  for (size_t i = 0; i < below.size(); ++i) {
    if (nearest[i] < 0 || (support_points[nearest[i]] - cloud.position[below[i]]).norm() > 3 * link) continue;
    place[below[i]] = Place::kBackground, rule[below[i]] = ExtractRule::kToSupport;
    ++summary.contact_to_support;
  }
}

/// Background Gaussians most of whose neighbours are the object's belong to it: specks that would stay behind in the air
/// when it moves.  Repeated until nothing changes.
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
    for (size_t p : enclosed) place[p] = Place::kObject, rule[p] = ExtractRule::kEnclosed;
    taken += enclosed.size();
    if (enclosed.empty()) break;
  }
  return taken;
}

/// Gives background inside the convex hull of the object, and above its contact, to it.
size_t take_hull(const GaussianCloud& cloud, const ContactRegion& contact, std::vector<Place>& place, std::vector<ExtractRule>& rule) {
  const std::vector<Vec3f> object = positions(cloud, indices_of(place, Place::kObject));
  const ConvexHull hull(object);
  std::vector<uint8_t> inside(place.size(), 0);
  parallel_for(static_cast<std::ptrdiff_t>(place.size()), [&](std::ptrdiff_t p) {
    if (place[p] != Place::kBackground || (contact.found && contact.height(cloud.position[p]) <= contact_tolerance(contact))) return;
    inside[p] = hull.contains(cloud.position[p]);
  }, 256);
  size_t taken = 0;
  for (size_t p = 0; p < place.size(); ++p)
    if (inside[p]) place[p] = Place::kObject, rule[p] = ExtractRule::kHull, ++taken;
  return taken;
}

/// Opacity that each rule moved, as a share of `whole`.
std::array<double, kExtractRules> opacity_shares(const GaussianCloud& cloud, const std::vector<ExtractRule>& rule, double whole) {
  std::array<double, kExtractRules> share = {};
  for (size_t p = 0; p < rule.size(); ++p)
    if (rule[p] != ExtractRule::kNone) share[static_cast<int>(rule[p])] += sigmoid(cloud.opacity_logit[p]) / std::max(whole, 1e-12);
  return share;
}

}  // namespace

const char* name_of(ExtractRule rule) {
  static const char* const kNames[kExtractRules] = {"", "probability", "outlier", "floater", "to support", "from support", "enclosed", "hull"};
  return kNames[static_cast<int>(rule)];
}

std::string ExtractSummary::describe() const {
  return std::to_string(candidates) + " candidates; taken away: " + std::to_string(below_probability) + " below the probability threshold, " +
         std::to_string(outliers) + " outliers, " + std::to_string(floaters) + " floaters (" + std::to_string(dropped) +
         " of both dropped), " + std::to_string(contact_to_support) + " to the support; " + std::to_string(contact_to_object) +
         " taken from the support, " + std::to_string(enclosed) + " from among its own, " + std::to_string(hull) +
         " from inside its hull";
}

ExtractResult extract(const ExtractOptions& options, const GaussianCloud& cloud, const Segmentation& segmentation) {
  CHECK(segmentation.label.size() == cloud.size());
  const int cls = class_of_id(segmentation, options.object);
  if (cls < 0) {
    std::string known;
    for (size_t c = 0; c < segmentation.class_id.size(); ++c)
      known += (c ? ", " : "") + std::to_string(segmentation.class_id[c]) + " " + segmentation.class_name[c];
    throw usage_error("--object", "", "names id " + std::to_string(options.object) + ", which the segmentation does not have",
                      "choose one of: " + known);
  }
  ExtractResult result;
  ExtractSummary& summary = result.summary;

  // Probability.
  std::vector<float> probability(cloud.size());
  parallel_for(static_cast<std::ptrdiff_t>(cloud.size()),
               [&](std::ptrdiff_t p) { probability[p] = class_probabilities(segmentation, p)[cls]; }, 1024);
  std::vector<Place> place(cloud.size(), Place::kBackground);
  std::vector<ExtractRule>& rule = result.rule;
  rule.assign(cloud.size(), ExtractRule::kNone);
  double whole = 0;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (probability[p] >= options.probability) {
      place[p] = Place::kObject, ++summary.candidates, whole += sigmoid(cloud.opacity_logit[p]);
    } else if (segmentation.label[p] == options.object) {
      rule[p] = ExtractRule::kProbability, ++summary.below_probability;
    }
  }
  const auto nothing_left = [&] {
    return input_error("object " + std::to_string(options.object), segmentation.class_name[cls],
                       "has no Gaussian left: " + summary.describe(), "lower the probability threshold or check the masks");
  };
  if (summary.candidates == 0) throw nothing_left();

  // Outliers, then floaters; what has no background near is dropped, because left behind it would hang in the air.
  std::vector<int> members = indices_of(place, Place::kObject);
  std::vector<int> others = indices_of(place, Place::kBackground), taken;
  std::vector<uint8_t> marked;
  const float spacing = mark_outliers(cloud, members, options.outlier_neighbours, options.outlier_sigma, marked);
  auto take_marked = [&](ExtractRule why, size_t& count) {
    std::vector<int> kept;
    for (size_t i = 0; i < members.size(); ++i) {
      (marked[i] ? taken : kept).push_back(members[i]);
      if (marked[i]) rule[members[i]] = why;
    }
    count = members.size() - kept.size();
    members = std::move(kept);
  };
  take_marked(ExtractRule::kOutlier, summary.outliers);
  const float link = 3 * spacing;
  mark_floaters(cloud, members, link, options.floater_share, marked);
  take_marked(ExtractRule::kFloater, summary.floaters);
  const std::vector<int> nearest = k_nearest(positions(cloud, others), positions(cloud, taken), 1);
  for (size_t i = 0; i < taken.size(); ++i) {
    const bool background_near = nearest[i] >= 0 && (cloud.position[others[nearest[i]]] - cloud.position[taken[i]]).norm() <= link;
    place[taken[i]] = background_near ? Place::kBackground : Place::kDropped;
    summary.dropped += !background_near;
  }

  // Contact with the support.
  const std::vector<int> background = indices_of(place, Place::kBackground);
  summary.support = options.support ? options.support : find_support(cloud, segmentation, members, background, options.up);
  if (summary.support != 0 && class_of_id(segmentation, summary.support) < 0)
    throw usage_error("support", "", "is id " + std::to_string(summary.support) + ", which the segmentation does not have",
                      "name an id of the scene");
  std::vector<int> support;
  for (int p : background)
    if (segmentation.label[p] == summary.support) support.push_back(p);
  const GaussianCloud support_cloud = cloud.select(support);
  result.contact = contact_region(cloud.select(members), support_cloud, options.up);
  if (result.contact.found) {
    settle_contact(cloud, segmentation, summary.support, options.support != 0, link, result.contact, place, rule, summary);
    result.contact = contact_region(cloud.select(indices_of(place, Place::kObject)), support_cloud, options.up);
  }
  if (options.enclosed) summary.enclosed = take_enclosed(cloud, place, rule);
  if (options.hull) summary.hull = take_hull(cloud, result.contact, place, rule);
  summary.opacity_share = opacity_shares(cloud, rule, whole);
  result.object = indices_of(place, Place::kObject);
  result.background = indices_of(place, Place::kBackground);
  result.dropped = indices_of(place, Place::kDropped);
  if (result.object.empty()) throw nothing_left();
  return result;
}

}  // namespace pliant
