#include "segmentation/labels/spread.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "gaussians/base/nearest.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

std::vector<int> nearest_seen(std::span<const Vec3f> position, const std::vector<uint8_t>& seen) {
  constexpr int kNeighbours = 8;
  const int n = static_cast<int>(position.size());
  std::vector<int> source(n, -1), gaps;
  for (int p = 0; p < n; ++p) {
    if (seen[p])
      source[p] = p;
    else
      gaps.push_back(p);
  }
  if (gaps.empty() || gaps.size() == seen.size()) return source;

  // Edges of the neighbour graph that touch an unseen point, from both ends.
  std::vector<Vec3f> gap_points(gaps.size());
  for (size_t g = 0; g < gaps.size(); ++g) gap_points[g] = position[gaps[g]];
  const std::vector<int> nearest = k_nearest(position, gap_points, kNeighbours + 1);
  std::vector<std::pair<int, int>> edges;  // from, to an unseen point
  for (size_t g = 0; g < gaps.size(); ++g)
    for (int j = 0; j <= kNeighbours; ++j) {
      const int other = nearest[g * (kNeighbours + 1) + j];
      if (other < 0 || other == gaps[g]) continue;
      edges.emplace_back(other, gaps[g]);
      if (!seen[other]) edges.emplace_back(gaps[g], other);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  auto edges_of = [&](int p) { return std::lower_bound(edges.begin(), edges.end(), std::pair(p, -1)); };

  // Dijkstra from all seen points at once; ties go to the lower index.
  using Entry = std::tuple<float, int, int>;  // cost, point, source
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  std::vector<float> cost(n, INFINITY);
  auto relax = [&](int p, float so_far, int from) {
    for (auto edge = edges_of(p); edge != edges.end() && edge->first == p; ++edge) {
      const float next = so_far + (position[edge->second] - position[p]).squaredNorm();
      if (next < cost[edge->second]) {
        cost[edge->second] = next;
        queue.emplace(next, edge->second, from);
      }
    }
  };
  for (int p = 0; p < n; ++p)
    if (seen[p]) relax(p, 0.0f, p);
  while (!queue.empty()) {
    const auto [so_far, p, from] = queue.top();
    queue.pop();
    if (source[p] >= 0) continue;
    source[p] = from;
    relax(p, so_far, from);
  }

  // Islands without a seen point take the nearest one.
  std::vector<int> seen_index;
  std::vector<Vec3f> seen_points;
  for (int p = 0; p < n; ++p)
    if (seen[p]) {
      seen_index.push_back(p);
      seen_points.push_back(position[p]);
    }
  const NearestPoints tree(seen_points);
  std::vector<NearestPoints::Hit> hits;
  for (int p : gaps) {
    if (source[p] >= 0) continue;
    tree.query(position[p], 1, hits);
    source[p] = seen_index[hits[0].index];
  }
  return source;
}

void copy_attributes(const std::vector<int>& source, std::vector<float>& attribute) {
  constexpr int kY = kSemanticChannels;
  for (size_t p = 0; p < source.size(); ++p)
    if (source[p] >= 0 && source[p] != static_cast<int>(p))
      std::copy_n(attribute.data() + static_cast<size_t>(source[p]) * kY, kY, attribute.data() + p * kY);
}

}  // namespace pliant
