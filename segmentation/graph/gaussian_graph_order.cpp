// Orders of nodes by paths along the edges, and where to cut them.

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "segmentation/graph/gaussian_graph.h"

namespace pliant {

Adjacency::Adjacency(size_t nodes, std::span<const CutEdge> edges) : start(nodes + 1, 0) {
  for (const CutEdge& e : edges) {
    ++start[e.a + 1];
    ++start[e.b + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> next(start.begin(), start.end() - 1);
  to.resize(start.back());
  edge.resize(start.back());
  for (size_t k = 0; k < edges.size(); ++k) {
    const CutEdge& e = edges[k];
    to[next[e.a]] = e.b;
    edge[next[e.a]++] = static_cast<int>(k);
    to[next[e.b]] = e.a;
    edge[next[e.b]++] = static_cast<int>(k);
  }
}

std::vector<int> order_from(const Adjacency& adjacency, std::span<const CutEdge> edges, const std::vector<int>& sources,
                            std::vector<float>* lengths, float limit) {
  const size_t n = adjacency.start.size() - 1;
  std::vector<float> length(n, INFINITY);
  using Step = std::pair<float, int>;
  std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
  for (int s : sources) {
    length[s] = 0;
    open.push({0.0f, s});
  }
  std::vector<uint8_t> taken(n, 0);
  std::vector<int> order;
  while (!open.empty()) {
    const auto [d, i] = open.top();
    open.pop();
    if (taken[i]) continue;
    taken[i] = 1;
    order.push_back(i);
    for (int e = adjacency.start[i]; e < adjacency.start[i + 1]; ++e) {
      const float weight = edges[adjacency.edge[e]].weight;
      if (!(weight > 1e-6f)) continue;
      const float next = d + 0.1f - std::log(weight);
      if (next <= limit && next < length[adjacency.to[e]]) {
        length[adjacency.to[e]] = next;
        open.push({next, adjacency.to[e]});
      }
    }
  }
  if (lengths) *lengths = std::move(length);
  return order;
}

std::vector<int> order_from(const GaussianGraph& graph, const std::vector<int>& sources, std::vector<float>* lengths) {
  return order_from(Adjacency(graph.nodes.size(), graph.edges), graph.edges, sources, lengths);
}

std::vector<int> order_apart(const Adjacency& adjacency, std::span<const CutEdge> edges,
                             const std::vector<int>& sources, const std::vector<int>& rivals, float share) {
  std::vector<float> path, rival;
  std::vector<int> order = order_from(adjacency, edges, sources, &path);
  if (rivals.empty()) return order;
  order_from(adjacency, edges, rivals, &rival);
  std::erase_if(order, [&](int i) { return rival[i] < share * path[i]; });
  return order;
}

size_t best_sweep(const Adjacency& adjacency, std::span<const CutEdge> edges, std::span<const double> inner,
                  const std::vector<int>& order, size_t fewest) {
  const size_t n = adjacency.start.size() - 1;
  std::vector<double> degree(n, 0);
  double total = 0;
  for (const CutEdge& e : edges) {
    degree[e.a] += e.weight;
    degree[e.b] += e.weight;
    total += 2.0 * e.weight;
  }
  for (size_t i = 0; i < inner.size(); ++i) {
    degree[i] += 2 * inner[i];
    total += 2 * inner[i];
  }
  std::vector<uint8_t> inside(n, 0);
  double cut = 0, volume = 0, least = INFINITY;
  size_t best = std::min(fewest, order.size());
  for (size_t k = 0; k < order.size() && volume < 0.5 * total; ++k) {
    const int i = order[k];
    double shared = inner.empty() ? 0 : inner[i];
    for (int e = adjacency.start[i]; e < adjacency.start[i + 1]; ++e)
      if (inside[adjacency.to[e]]) shared += edges[adjacency.edge[e]].weight;
    inside[i] = 1;
    volume += degree[i];
    cut += degree[i] - 2 * shared;
    if (k + 1 < fewest || !(volume > 0)) continue;
    const double conductance = cut / std::max(1e-12, std::min(volume, total - volume));
    if (conductance < least) {
      least = conductance;
      best = k + 1;
    }
  }
  return best;
}

}  // namespace pliant
