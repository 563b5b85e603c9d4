#include "segmentation/lift/split.h"

#include <algorithm>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"

namespace pliant {
namespace {

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
  return std::max(1, static_cast<int>(std::count_if(mass.begin(), mass.end(), [&](double m) { return m >= share * total; })));
}

/// Label 1 for the side of one end, 0 for the other's.
std::vector<uint8_t> cut_between_ends(const SplitOptions& options, const GaussianGraph& graph) {
  const size_t n = graph.nodes.size();
  // Twice the farthest node from where one is, as for the diameter of a tree.
  const std::vector<int> inner = order_from(graph, {0});
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
  evidence[inner.back()] = kSure, evidence[order_a.back()] = -kSure;
  hold(order_a, kSure), hold(order_b, -kSure);
  cut_graph(options.cut, graph, evidence, label);
  return label;
}

}  // namespace

SplitResult split_object(const SplitOptions& options, const GaussianCloud& cloud, std::span<const uint8_t> member) {
  GaussianGraph graph = gaussian_graph(cloud, member, options.neighbours);
  SplitResult result;
  result.part.assign(cloud.size(), -1);
  if (graph.nodes.empty()) return result;
  std::vector<int> part = connected_parts(graph, std::vector<uint8_t>(graph.nodes.size(), 1), options.link, true);
  result.parts = large_parts(graph, part, options.crumb);
  if (result.parts == 1 && graph.nodes.size() > 2) {
    graph.border.clear(), graph.border_nearness.clear();  // what lies around the object is on neither side
    const std::vector<uint8_t> label = cut_between_ends(options, graph);
    double mass[2] = {0, 0}, ties[2] = {0, 0}, through = 0;
    for (size_t i = 0; i < label.size(); ++i) mass[label[i]] += graph.opacity[i];
    for (const CutEdge& e : graph.edges) {
      through += label[e.a] != label[e.b] ? e.weight : 0;
      ties[label[e.a]] += e.weight, ties[label[e.b]] += e.weight;
    }
    if (mass[0] > 0 && mass[1] > 0) {
      const uint8_t larger = mass[1] > mass[0];
      for (size_t i = 0; i < label.size(); ++i) part[i] = label[i] != larger;
      result.parts = 2, result.cut = true, result.cut_share = through / std::max(1e-12, std::min(ties[0], ties[1]));
    }
  }
  if (!result.cut) sweep_crumbs(cloud, graph, result.parts, part);
  for (size_t i = 0; i < part.size(); ++i) result.part[graph.nodes[i]] = part[i];
  return result;
}

}  // namespace pliant
