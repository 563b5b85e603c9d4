#include "segmentation/objects/split.h"

#include <algorithm>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

constexpr float kNoTie = 1e-6f;  // order_from does not follow edges below it either

/// Gives nodes whose part is below `kept` parts the part of the nearest node that has one of them.
void sweep_crumbs(const GaussianCloud& cloud, const GaussianGraph& graph, int kept, std::vector<int>& part) {
  std::vector<Vec3f> whole, crumb;
  std::vector<size_t> of_whole, of_crumb;
  for (size_t i = 0; i < part.size(); ++i) {
    const bool large = part[i] < kept;
    (large ? whole : crumb).push_back(cloud.position[graph.nodes[i]]);
    (large ? of_whole : of_crumb).push_back(i);
  }
  const std::vector<int> nearest = k_nearest(whole, crumb, 1);
  for (size_t i = 0; i < crumb.size(); ++i) part[of_crumb[i]] = part[of_whole[nearest[i]]];
}

/// Number of parts that hold at least `share` of the opacity; parts are numbered by falling opacity.
int large_parts(const GaussianGraph& graph, const std::vector<int>& part, float share) {
  std::vector<double> mass(1 + *std::max_element(part.begin(), part.end()), 0);
  for (size_t i = 0; i < part.size(); ++i) mass[part[i]] += graph.opacity[i];
  const double total = std::accumulate(mass.begin(), mass.end(), 0.0);
  return std::max(
      1, static_cast<int>(std::count_if(mass.begin(), mass.end(), [&](double m) { return m >= share * total; })));
}

/// Weight of the edges from a part to others as a share of that of all its edges, of the part where it is largest.
double share_of_ties_cut(const GaussianGraph& graph, const std::vector<int>& part, int parts) {
  std::vector<double> ties(parts, 0), through(parts, 0);
  for (const CutEdge& e : graph.edges)
    for (const int p : {part[e.a], part[e.b]}) {
      ties[p] += e.weight;
      if (part[e.a] != part[e.b]) through[p] += e.weight;
    }
  double share = 0;
  for (int p = 0; p < parts; ++p) share = std::max(share, through[p] / std::max(1e-12, ties[p]));
  return share;
}

/// Label 1 for the side of one end, 0 for the other's; both are reached from `start`.
std::vector<uint8_t> cut_between_ends(const SplitOptions& options, const GaussianGraph& graph, int start) {
  const size_t n = graph.nodes.size();
  // Twice the farthest node from where one is, as for the diameter of a tree.
  const std::vector<int> inner = order_from(graph, {start});
  std::vector<float> from_a, from_b;
  const std::vector<int> order_a = order_from(graph, {inner.back()}, &from_a);
  const std::vector<int> order_b = order_from(graph, {order_a.back()}, &from_b);
  const size_t fixed = std::max<size_t>(1, static_cast<size_t>(options.ends * static_cast<float>(n)));
  std::vector<float> evidence(n, 0.0f);
  std::vector<uint8_t> label(n);
  for (size_t i = 0; i < n; ++i) label[i] = from_a[i] < from_b[i];
  constexpr float kSure = 100;
  const auto hold = [&](const std::vector<int>& order, float value) {
    for (size_t k = 0; k < std::min(fixed, order.size() / 3); ++k) evidence[order[k]] = value;
  };
  evidence[inner.back()] = kSure;
  evidence[order_a.back()] = -kSure;
  hold(order_a, kSure);
  hold(order_b, -kSure);
  cut_graph(options.cut, graph, evidence, label);
  return label;
}

}  // namespace

SplitResult split_object(const SplitOptions& options, const GaussianCloud& cloud, std::span<const uint8_t> member) {
  GaussianGraph graph = gaussian_graph(cloud, member, options.neighbours);
  SplitResult result;
  result.part.assign(cloud.size(), -1);
  if (graph.nodes.empty()) return result;
  const std::vector<uint8_t> all(graph.nodes.size(), 1);
  std::vector<int> part = connected_parts(graph, all, options.link, true);
  result.parts = large_parts(graph, part, options.crumb);
  if (result.parts == 1 && graph.nodes.size() > 2) {
    // One piece: where colours change so sharply that nothing ties the sides together, else the best cut.
    part = connected_parts(graph, all, kNoTie);
    result.parts = large_parts(graph, part, options.crumb);
    if (result.parts == 1) {
      const std::vector<int> before = part;
      graph.border.clear();
      graph.border_nearness.clear();  // what lies around the object is on neither side
      const std::vector<uint8_t> label =
          cut_between_ends(options, graph, static_cast<int>(std::find(part.begin(), part.end(), 0) - part.begin()));
      double mass[2] = {0, 0};
      for (size_t i = 0; i < label.size(); ++i) mass[label[i]] += graph.opacity[i];
      const uint8_t larger = mass[1] > mass[0];
      for (size_t i = 0; i < label.size(); ++i) part[i] = before[i] > 0 ? 2 : label[i] != larger;  // crumbs are no side
      result.parts = mass[0] > 0 && mass[1] > 0 ? 2 : 1;
    }
    result.cut = result.parts > 1;
  }
  sweep_crumbs(cloud, graph, result.parts, part);
  if (result.cut) result.cut_share = share_of_ties_cut(graph, part, result.parts);
  for (size_t i = 0; i < part.size(); ++i) result.part[graph.nodes[i]] = part[i];
  return result;
}

}  // namespace pliant
