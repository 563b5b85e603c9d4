// The cut of the graph: first of its superpoints, then of the Gaussians along the border that this leaves.

#include <algorithm>
#include <cmath>

#include "gaussians/base/portable.h"
#include "segmentation/select/selector.h"

namespace pliant {

void Selector::cut(const GraphCutOptions& options) {
  const Superpoints& parts = scene_.parts;
  const size_t n = cloud_.size(), count = parts.size();
  // What is known of every superpoint, of its members alone.
  std::vector<float> fixed(n, 0.0f), gain(count, 0.0f), opacity(count, 0.0f), visible(count, 0.0f), chosen(count, 0.0f);
  std::vector<uint8_t> seeds(count, 0);
  for (size_t p = 0; p < n; ++p) {
    if (!member_[p]) continue;
    const int k = parts.part[p];
    fixed[p] = evidence_[p] - options.smoothness * held_[p];
    gain[k] += fixed[p];
    opacity[k] += graph_.opacity[p];
    visible[k] += std::min(1.0f, 2 * graph_.opacity[p]);
    chosen[k] += label_[p] ? graph_.opacity[p] : 0;
    seeds[k] |= fixed_[p] > 0 ? 1 : fixed_[p] < 0 ? 2 : 0;
  }
  std::vector<CutEdge> edges = parts.edges;
  for (size_t e = 0; e < edges.size(); ++e) edges[e].weight = options.smoothness * coarse_weight_[e];
  std::vector<uint8_t> label(count);
  for (size_t k = 0; k < count; ++k) label[k] = 2 * chosen[k] > opacity[k];

  ColorModelOptions model = options.model;
  model.seed = options_.seed;
  ColorModel models[2];
  const auto ratio = [&](const Vec3f& lab) {
    if (models[0].empty() || models[1].empty()) return 0.0f;
    return options.color *
           std::clamp(models[1].log_density(lab) - models[0].log_density(lab), -options.color_clip, options.color_clip);
  };
  for (int round = 0; round < options.rounds; ++round) {
    parallel_for(2, [&](std::ptrdiff_t side) {
      std::vector<Vec3f> colors;
      std::vector<float> weights;
      for (size_t k = 0; k < count; ++k)
        if (label[k] == side && opacity[k] > 0) {
          colors.push_back(parts.lab[k]);
          weights.push_back(opacity[k]);
        }
      models[side] = ColorModel::fit(model, colors, weights);
    });
    std::vector<float> with_color = gain;
    parallel_for(
        static_cast<std::ptrdiff_t>(count),
        [&](std::ptrdiff_t k) {
          if (visible[k] > 0) with_color[k] += ratio(parts.lab[k]) * visible[k];
        },
        512);
    std::vector<uint8_t> next = min_cut(with_color, edges);
    const bool same = next == label;
    label = std::move(next);
    if (same) break;
  }

  // Gaussians of superpoints on either side of the border, and of those in which strokes of both kinds lie.
  std::vector<uint8_t> open(count);
  for (size_t k = 0; k < count; ++k) open[k] = seeds[k] == 3;
  for (const CutEdge& e : edges)
    if (e.weight > 0 && label[e.a] != label[e.b]) open[e.a] = open[e.b] = 1;
  std::vector<int> node(n, -1), nodes;
  for (size_t p = 0; p < n; ++p) {
    const int k = parts.part[p];
    label_[p] = member_[p] && label[k];
    if (!member_[p] || !open[k]) continue;
    node[p] = static_cast<int>(nodes.size());
    nodes.push_back(static_cast<int>(p));
  }
  std::vector<float> fine(nodes.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(nodes.size()),
      [&](std::ptrdiff_t i) {
        const int p = nodes[i];
        fine[i] = fixed[p] + ratio(graph_.lab[p]) * std::min(1.0f, 2 * graph_.opacity[p]);
      },
      512);
  std::vector<CutEdge> fine_edges;
  for (const CutEdge& e : graph_.edges) {
    const int a = node[e.a], b = node[e.b];
    if (a < 0 && b < 0) continue;
    const float weight = options.smoothness * e.weight;
    if (a >= 0 && b >= 0)
      fine_edges.push_back({a, b, weight});
    else if (member_[e.a] && member_[e.b])
      fine[std::max(a, b)] += label_[a < 0 ? e.a : e.b] ? weight : -weight;
  }
  const std::vector<uint8_t> border = min_cut(fine, fine_edges);
  for (size_t i = 0; i < nodes.size(); ++i) label_[nodes[i]] = border[i];
}

}  // namespace pliant
