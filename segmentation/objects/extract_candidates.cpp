// What the candidates lose: outliers and floaters.

#include <algorithm>
#include <cmath>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/quantile.h"
#include "segmentation/objects/extract_steps.h"

namespace pliant {
namespace {

/// Standard deviation along the longest axis.
float extent(const GaussianCloud& cloud, int p) { return std::exp(cloud.log_scale[p].maxCoeff()); }

/// k nearest others of every point, [points, k], -1 where there are fewer.
std::vector<int> neighbours_of(const std::vector<Vec3f>& points, int k) {
  const std::vector<int> with_self = k_nearest(points, points, k + 1);
  std::vector<int> out(points.size() * k, -1);
  for (size_t i = 0; i < points.size(); ++i) {
    int found = 0;
    for (int j = 0; j <= k && found < k; ++j)
      if (const int other = with_self[i * (k + 1) + j]; other >= 0 && other != static_cast<int>(i))
        out[i * k + found++] = other;
  }
  return out;
}

}  // namespace

std::vector<Vec3f> positions(const GaussianCloud& cloud, const std::vector<int>& indices) {
  std::vector<Vec3f> points(indices.size());
  for (size_t i = 0; i < indices.size(); ++i) points[i] = cloud.position[indices[i]];
  return points;
}

std::vector<int> indices_of(const std::vector<Place>& place, Place which) {
  std::vector<int> out;
  for (size_t p = 0; p < place.size(); ++p)
    if (place[p] == which) out.push_back(static_cast<int>(p));
  return out;
}

float touching_distance(const GaussianCloud& cloud, int a, int b, float link) {
  constexpr float kFarthest = 5;  // links; haze that reaches farther holds nothing together
  return std::clamp(2 * (extent(cloud, a) + extent(cloud, b)), link, kFarthest * link);
}

std::vector<int> parts_of(const GaussianCloud& cloud, const std::vector<int>& members, float link) {
  constexpr int kNeighbours = 10;
  const std::vector<Vec3f> points = positions(cloud, members);
  const std::vector<int> near = neighbours_of(points, kNeighbours);
  DisjointSets parts(points.size());
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    for (int j = 0; j < kNeighbours; ++j) {
      const int n = near[static_cast<size_t>(i) * kNeighbours + j];
      if (n < 0) continue;
      if ((points[n] - points[i]).norm() <= touching_distance(cloud, members[i], members[n], link))
        parts.join_into(n, i);
    }
  std::vector<int> root(points.size());
  for (size_t i = 0; i < root.size(); ++i) root[i] = parts.find(static_cast<int>(i));
  return root;
}

float mark_outliers(const GaussianCloud& cloud, const std::vector<int>& members, int k, float sigma,
                    std::vector<uint8_t>& outlier) {
  const std::vector<Vec3f> points = positions(cloud, members);
  const std::vector<int> near = neighbours_of(points, k);
  std::vector<float> distance(points.size(), 0.0f);
  double sum = 0, squares = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    int count = 0;
    for (int j = 0; j < k; ++j)
      if (const int n = near[i * k + j]; n >= 0) {
        distance[i] += (points[n] - points[i]).norm();
        ++count;
      }
    if (count) distance[i] /= static_cast<float>(count);
    sum += distance[i];
    squares += double(distance[i]) * distance[i];
  }
  const double mean = sum / points.size(), deviation = std::sqrt(std::max(0.0, squares / points.size() - mean * mean));
  outlier.assign(points.size(), 0);
  for (size_t i = 0; i < points.size(); ++i)
    outlier[i] = distance[i] > mean + sigma * deviation && distance[i] > 3 * extent(cloud, members[i]);
  return quantile(distance, 0.5);
}

void mark_floaters(const GaussianCloud& cloud, const std::vector<int>& members, float link, float share,
                   std::vector<uint8_t>& floater) {
  const std::vector<int> part = parts_of(cloud, members, link);
  std::vector<size_t> size(part.size(), 0);
  for (int of : part) ++size[of];
  const size_t largest = size.empty() ? 0 : *std::max_element(size.begin(), size.end());
  floater.assign(part.size(), 0);
  std::vector<int> kept, small;
  for (size_t i = 0; i < part.size(); ++i) {
    floater[i] = static_cast<float>(size[part[i]]) < share * static_cast<float>(largest);
    (floater[i] ? small : kept).push_back(static_cast<int>(i));
  }
  // A dense part may touch another though its Gaussians have their neighbours among themselves.
  const auto points_of = [&](const std::vector<int>& places) {
    std::vector<Vec3f> points;
    for (const int i : places) points.push_back(cloud.position[members[i]]);
    return points;
  };
  const std::vector<Vec3f> bodies = points_of(kept), specks = points_of(small);
  const std::vector<int> nearest = k_nearest(bodies, specks, 1);
  std::vector<uint8_t> touches(part.size(), 0);
  for (size_t k = 0; k < small.size(); ++k) {
    if (nearest[k] < 0) continue;
    const float reach = touching_distance(cloud, members[small[k]], members[kept[nearest[k]]], link);
    if ((bodies[nearest[k]] - specks[k]).norm() <= reach) touches[part[small[k]]] = 1;
  }
  for (const int i : small) floater[i] = !touches[part[i]];
}

}  // namespace pliant
