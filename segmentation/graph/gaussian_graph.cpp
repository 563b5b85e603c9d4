#include "segmentation/graph/gaussian_graph.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr size_t kOutsideSamples = 3000;

Vec3f rgb_of(const GaussianCloud& cloud, size_t p) { return dc_color(cloud.sh_of(p)).cwiseMax(0.0f).cwiseMin(1.0f); }

}  // namespace

GaussianGraph gaussian_graph(const GaussianCloud& cloud, std::span<const uint8_t> member, int neighbours) {
  CHECK(member.size() == cloud.size() && neighbours > 0);
  GaussianGraph graph;
  std::vector<int> place(cloud.size(), -1);
  std::vector<Vec3f> centres;
  for (size_t p = 0; p < cloud.size(); ++p) {
    if (!member[p]) continue;
    place[p] = static_cast<int>(graph.nodes.size());
    graph.nodes.push_back(static_cast<int>(p));
    centres.push_back(cloud.position[p]);
    graph.lab.push_back(lab_of_rgb(rgb_of(cloud, p)));
    graph.opacity.push_back(sigmoid(cloud.opacity_logit[p]));
  }
  const size_t step = std::max<size_t>(1, (cloud.size() - graph.nodes.size()) / kOutsideSamples);
  for (size_t p = 0, outside = 0; p < cloud.size(); ++p)
    if (!member[p] && outside++ % step == 0) {
      graph.outside_lab.push_back(lab_of_rgb(rgb_of(cloud, p)));
      graph.outside_opacity.push_back(sigmoid(cloud.opacity_logit[p]));
    }
  const int k = neighbours + 1;  // the first one is the Gaussian itself or one at the same place
  const std::vector<int> near = k_nearest(cloud.position, centres, k);

  std::vector<float> fifth;
  std::vector<std::pair<int, int>> pairs;  // node, Gaussian
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (const int p = near[i * k + std::min(5, neighbours)]; p >= 0)
      fifth.push_back((cloud.position[p] - centres[i]).norm());
    for (int j = 0; j < k; ++j) {
      const int p = near[i * k + j];
      if (p < 0 || p == graph.nodes[i]) continue;
      if (place[p] < 0) {
        pairs.emplace_back(static_cast<int>(i), p);
      } else {
        pairs.emplace_back(std::min<int>(i, place[p]), graph.nodes[std::max<int>(i, place[p])]);
      }
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  graph.spacing = quantile(fifth, 0.5);
  std::vector<float> difference(pairs.size()), weight(pairs.size()), nearness(pairs.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(pairs.size()),
      [&](std::ptrdiff_t e) {
        difference[e] = (rgb_of(cloud, graph.nodes[pairs[e].first]) - rgb_of(cloud, pairs[e].second)).squaredNorm();
      },
      4096);
  const float typical = std::max(quantile(difference, 0.5), 1e-8f);
  parallel_for(
      static_cast<std::ptrdiff_t>(pairs.size()),
      [&](std::ptrdiff_t e) {
        const int p = graph.nodes[pairs[e].first], q = pairs[e].second;
        const float reach = std::exp(cloud.log_scale[p].maxCoeff()) + std::exp(cloud.log_scale[q].maxCoeff());
        const float d = (cloud.position[p] - cloud.position[q]).norm() / std::max({2 * graph.spacing, reach, 1e-12f});
        nearness[e] =
            std::exp(-0.5f * d * d) * std::sqrt(sigmoid(cloud.opacity_logit[p]) * sigmoid(cloud.opacity_logit[q]));
        weight[e] = std::exp(-std::min(0.25f * difference[e] / typical, 20.0f)) * nearness[e];
      },
      4096);
  for (size_t e = 0; e < pairs.size(); ++e) {
    const auto [i, q] = pairs[e];
    const bool inner = place[q] >= 0;
    (inner ? graph.edges : graph.border).push_back({i, inner ? place[q] : q, weight[e]});
    (inner ? graph.edge_nearness : graph.border_nearness).push_back(nearness[e]);
  }
  return graph;
}

void cut_graph(const GraphCutOptions& options, const GaussianGraph& graph, std::span<const float> evidence,
               std::vector<uint8_t>& label) {
  const size_t n = graph.nodes.size();
  CHECK(evidence.size() == n && label.size() == n);
  std::vector<CutEdge> edges = graph.edges;
  for (CutEdge& edge : edges) edge.weight *= options.smoothness;
  std::vector<float> fixed(evidence.begin(), evidence.end());
  for (const CutEdge& edge : graph.border) fixed[edge.a] -= options.smoothness * edge.weight;

  ColorModel models[2];
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<float> gain = fixed;
    if (options.color > 0) {
      for (uint8_t side = 0; side < 2; ++side) {
        std::vector<Vec3f> colors;
        std::vector<float> weights;
        for (size_t i = 0; i < n; ++i)
          if (label[i] == side) {
            colors.push_back(graph.lab[i]);
            weights.push_back(graph.opacity[i]);
          }
        if (side == 0 && options.outside > 0 && !graph.outside_lab.empty()) {
          double inner = 0, outer = 0;
          for (float w : weights) inner += w;
          for (float w : graph.outside_opacity) outer += w;
          const double factor = inner > 0 ? options.outside / (1 - options.outside) * inner / outer : 1.0;
          colors.insert(colors.end(), graph.outside_lab.begin(), graph.outside_lab.end());
          for (float w : graph.outside_opacity) weights.push_back(static_cast<float>(factor * w));
        }
        models[side] = ColorModel::fit(options.model, colors, weights);
      }
      if (!models[0].empty() && !models[1].empty())
        parallel_for(
            static_cast<std::ptrdiff_t>(n),
            [&](std::ptrdiff_t i) {
              const float ratio = models[1].log_density(graph.lab[i]) - models[0].log_density(graph.lab[i]);
              gain[i] += options.color * std::clamp(ratio, -options.color_clip, options.color_clip) *
                         std::min(1.0f, 2 * graph.opacity[i]);
            },
            1024);
    }
    std::vector<uint8_t> next = min_cut(gain, edges);
    const bool same = next == label;
    label = std::move(next);
    if (same) break;
  }
}

std::vector<int> connected_parts(const GaussianGraph& graph, const std::vector<uint8_t>& label, float link,
                                 bool nearness) {
  const size_t n = graph.nodes.size();
  DisjointSets sets(n);
  std::vector<int> part(n, -1);
  for (size_t k = 0; k < graph.edges.size(); ++k) {
    const CutEdge& e = graph.edges[k];
    const float tie = nearness ? graph.edge_nearness[k] : e.weight;
    if (label[e.a] && label[e.b] && tie > link) sets.join_into(e.b, e.a);
  }
  std::vector<double> mass(n, 0);
  std::vector<int> roots;
  for (size_t i = 0; i < n; ++i)
    if (label[i]) mass[sets.find(static_cast<int>(i))] += graph.opacity[i];
  for (size_t i = 0; i < n; ++i)
    if (label[i] && sets.find(static_cast<int>(i)) == static_cast<int>(i)) roots.push_back(static_cast<int>(i));
  std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return mass[a] > mass[b]; });
  std::vector<int> number(n, -1);
  for (size_t k = 0; k < roots.size(); ++k) number[roots[k]] = static_cast<int>(k);
  for (size_t i = 0; i < n; ++i)
    if (label[i]) part[i] = number[sets.find(static_cast<int>(i))];
  return part;
}

std::vector<uint8_t> attached_parts(const GaussianGraph& graph, const std::vector<int>& part,
                                    std::vector<uint8_t> wanted) {
  std::vector<double> to_rest(wanted.size(), 0);
  std::map<std::pair<int, int>, double> between;
  for (size_t k = 0; k < graph.edges.size(); ++k) {
    const int a = part[graph.edges[k].a], b = part[graph.edges[k].b];
    const double tie = graph.edge_nearness[k];
    if (a >= 0 && b >= 0 && a != b) {
      between[{a, b}] += tie;
      between[{b, a}] += tie;
    }
    if (a >= 0 && b < 0) to_rest[a] += tie;
    if (b >= 0 && a < 0) to_rest[b] += tie;
  }
  for (size_t k = 0; k < graph.border.size(); ++k)
    if (const int a = part[graph.border[k].a]; a >= 0) to_rest[a] += graph.border_nearness[k];
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<double> to_object(wanted.size(), 0);
    for (const auto& [pair, tie] : between)
      if (wanted[pair.second]) to_object[pair.first] += tie;
    for (size_t k = 0; k < wanted.size(); ++k)
      if (!wanted[k] && to_object[k] > 2 * to_rest[k]) {
        wanted[k] = 1;
        changed = true;
      }
  }
  return wanted;
}

std::vector<int> enclosed_nodes(const GaussianGraph& graph, const std::vector<uint8_t>& label,
                                const std::vector<float>& outside, float link, float least, float touch) {
  const size_t n = graph.nodes.size();
  CHECK(label.size() == n && outside.size() == n);
  std::vector<uint8_t> away(n);
  double object = 0;
  for (size_t i = 0; i < n; ++i) {
    away[i] = !label[i];
    object += label[i] ? graph.opacity[i] : 0;
  }
  const std::vector<int> part = connected_parts(graph, away, link, true);
  std::vector<double> mass(n, 0), ties(n, 0);
  for (size_t i = 0; i < n; ++i) {
    if (part[i] < 0) continue;
    mass[part[i]] += graph.opacity[i];
    if (outside[i] > 0) ties[part[i]] += outside[i] * std::max(graph.opacity[i], 1e-6f);
  }
  for (size_t k = 0; k < graph.border.size(); ++k)
    if (const int at = part[graph.border[k].a]; at >= 0) ties[at] += graph.border_nearness[k];
  std::vector<int> found;
  for (size_t i = 0; i < n; ++i)
    if (const int at = part[i]; at >= 0 && mass[at] >= least * object && ties[at] < touch * mass[at])
      found.push_back(static_cast<int>(i));
  return found;
}

float tied_share(const GaussianGraph& graph, const std::vector<uint8_t>& label) {
  double across = 0, within = 0;
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    const auto& [a, b, weight] = graph.edges[e];
    if (label[a] != label[b])
      across += graph.edge_nearness[e];
    else if (label[a])
      within += graph.edge_nearness[e];
  }
  return across + within > 0 ? static_cast<float>(across / (across + within)) : 1.0f;
}

}  // namespace pliant
