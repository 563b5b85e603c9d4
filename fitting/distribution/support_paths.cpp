#include "fitting/distribution/support_paths.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

constexpr int kNeighbours = 8;
constexpr float kSupportShare = 0.02f;

struct Edge {
  int to;
  float length;
};

std::vector<std::vector<Edge>> graph_of(std::span<const Vec3f> points) {
  const int n = static_cast<int>(points.size());
  std::vector<std::vector<Edge>> edges(n);
  const auto join = [&](int a, int b, float length) {
    edges[a].push_back({b, length});
    edges[b].push_back({a, length});
  };
  const std::vector<int> nearest = k_nearest(points, points, kNeighbours + 1);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k <= kNeighbours; ++k)
      if (const int j = nearest[i * (kNeighbours + 1) + k]; j >= 0 && j != i)
        join(i, j, (points[i] - points[j]).norm());
  std::vector<float> gap(n, INFINITY);
  std::vector<int> other(n, 0);
  std::vector<uint8_t> in(n, 0);
  for (int step = 0, added = 0; step + 1 < n; ++step) {
    in[added] = 1;
    int next = -1;
    for (int i = 0; i < n; ++i) {
      if (in[i]) continue;
      if (const float d = (points[i] - points[added]).squaredNorm(); d < gap[i]) {
        gap[i] = d;
        other[i] = added;
      }
      if (next < 0 || gap[i] < gap[next]) next = i;
    }
    join(next, other[next], std::sqrt(gap[next]));
    added = next;
  }
  return edges;
}

}  // namespace

SupportPaths support_paths(std::span<const Vec3f> points, std::span<const float> volume,
                           std::span<const float> height) {
  const size_t n = points.size();
  CHECK(n > 0 && volume.size() == n && height.size() == n);
  const auto edges = graph_of(points);
  const auto [low, high] = std::minmax_element(height.begin(), height.end());
  const float support = *low + kSupportShare * (*high - *low);

  SupportPaths out{std::vector<float>(n, INFINITY), std::vector<float>(n)};
  std::vector<int> parent(n, -1), order;
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (size_t i = 0; i < n; ++i) {
    if (height[i] > support) continue;
    out.length[i] = 0;
    queue.push({0, static_cast<int>(i)});
  }
  std::vector<uint8_t> done(n, 0);
  while (!queue.empty()) {
    const int i = queue.top().second;
    queue.pop();
    if (done[i]) continue;
    done[i] = 1;
    order.push_back(i);
    for (const Edge& e : edges[i]) {
      if (const float length = out.length[i] + e.length; length < out.length[e.to]) {
        out.length[e.to] = length;
        parent[e.to] = i;
        queue.push({length, e.to});
      }
    }
  }
  CHECK(order.size() == n);
  double total = 0;
  for (const float v : volume) total += v;
  for (size_t i = 0; i < n; ++i) out.beyond[i] = static_cast<float>(volume[i] / total);
  for (size_t k = n; k-- > 0;)
    if (parent[order[k]] >= 0) out.beyond[parent[order[k]]] += out.beyond[order[k]];
  return out;
}

}  // namespace pliant
