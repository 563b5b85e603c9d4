#include "segmentation/graph/superpoints.h"

#include <algorithm>
#include <numeric>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/error.h"

namespace pliant {

Superpoints superpoints(const GaussianGraph& graph, int most) {
  CHECK(most > 0);
  const size_t n = graph.nodes.size();
  std::vector<int> order(graph.edges.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return graph.edges[a].weight > graph.edges[b].weight; });
  DisjointSets sets(n);
  std::vector<int> size(n, 1);
  for (const int e : order) {
    const int a = sets.find(graph.edges[e].a), b = sets.find(graph.edges[e].b);
    if (!(graph.edges[e].weight > 0)) break;
    if (a == b || size[a] + size[b] > most) continue;
    sets.join(a, b);
    size[std::min(a, b)] = size[a] + size[b];
  }

  Superpoints out;
  out.part.assign(n, -1);
  for (int i = 0; i < static_cast<int>(n); ++i) {
    const int first = sets.find(i);  // the smallest of its set
    if (first == i) {
      out.part[i] = static_cast<int>(out.lab.size());
      out.lab.push_back(Vec3f::Zero());
      out.opacity.push_back(0);
    }
    const int part = out.part[i] = out.part[first];
    out.lab[part] += graph.opacity[i] * graph.lab[i];
    out.opacity[part] += graph.opacity[i];
  }
  for (size_t k = 0; k < out.size(); ++k) out.lab[k] /= std::max(out.opacity[k], 1e-12f);

  const auto ends = [&](int e) {
    const int a = out.part[graph.edges[e].a], b = out.part[graph.edges[e].b];
    return std::pair(std::min(a, b), std::max(a, b));
  };
  std::vector<std::pair<std::pair<int, int>, int>> between;
  for (size_t e = 0; e < graph.edges.size(); ++e)
    if (const auto pair = ends(static_cast<int>(e)); pair.first != pair.second)
      between.push_back({pair, static_cast<int>(e)});
  std::sort(between.begin(), between.end());
  out.edge_of.assign(graph.edges.size(), -1);
  for (size_t k = 0; k < between.size(); ++k) {
    const auto& [pair, e] = between[k];
    if (k == 0 || between[k - 1].first != pair) {
      out.edges.push_back({pair.first, pair.second, 0.0f});
      out.edge_nearness.push_back(0);
    }
    out.edge_of[e] = static_cast<int>(out.edges.size()) - 1;
    out.edges.back().weight += graph.edges[e].weight;
    out.edge_nearness.back() += graph.edge_nearness[e];
  }
  return out;
}

}  // namespace pliant
