#include "segmentation/field/islands.h"

#include <algorithm>
#include <map>

#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"

namespace pliant {
namespace {

constexpr int kSpacingNeighbour = 4;  // the local spacing is the distance to this neighbour

struct Graph {
  int k;
  std::vector<int> near;       // [N, k + 1], the first one is the Gaussian itself or one at the same place
  std::vector<float> spacing;  // [N]
};

Graph neighbour_graph(const std::vector<Vec3f>& points, int k) {
  Graph graph{k + 1, k_nearest(points, points, k + 1), std::vector<float>(points.size(), 0.0f)};
  for (size_t i = 0; i < points.size(); ++i)
    if (const int n = graph.near[i * graph.k + std::min(kSpacingNeighbour, k)]; n >= 0)
      graph.spacing[i] = (points[n] - points[i]).norm();
  return graph;
}

/// Root of every Gaussian's part: parts are connected neighbours with the same label.
std::vector<int> connected_parts(const IslandOptions& options, const std::vector<Vec3f>& points, const Graph& graph,
                                 const std::vector<uint32_t>& label) {
  DisjointSets parts(points.size());
  for (int i = 0; i < static_cast<int>(points.size()); ++i)
    for (int j = 0; j < graph.k; ++j) {
      const int n = graph.near[static_cast<size_t>(i) * graph.k + j];
      if (n < 0 || n == i || label[n] != label[i]) continue;
      if ((points[n] - points[i]).norm() <= options.link * std::max(graph.spacing[i], graph.spacing[n]))
        parts.join_into(n, i);
    }
  std::vector<int> root(points.size());
  for (size_t i = 0; i < root.size(); ++i) root[i] = parts.find(static_cast<int>(i));
  return root;
}

}  // namespace

size_t merge_islands(const IslandOptions& options, const GaussianCloud& cloud, Segmentation& segmentation) {
  const std::vector<Vec3f>& points = cloud.position;
  std::vector<uint32_t>& label = segmentation.label;
  const Graph graph = neighbour_graph(points, options.neighbours);
  size_t changed = 0;
  for (int round = 0; round < options.rounds; ++round) {
    const std::vector<int> part = connected_parts(options, points, graph, label);
    std::map<int, size_t> size;
    std::map<uint32_t, size_t> largest;
    for (int root : part) largest[label[root]] = std::max(largest[label[root]], ++size[root]);
    auto island = [&](int i) {
      return static_cast<float>(size[part[i]]) < options.share * static_cast<float>(largest[label[i]]);
    };

    // What lies against each island: links to other labels, and the attributes found there.
    struct Border {
      size_t links = 0;
      Eigen::Matrix<float, kSemanticChannels, 1> sum = Eigen::Matrix<float, kSemanticChannels, 1>::Zero();
    };
    std::map<int, std::map<uint32_t, Border>> borders;
    for (int i = 0; i < static_cast<int>(points.size()); ++i) {
      if (!island(i)) continue;
      for (int j = 0; j < graph.k; ++j) {
        const int n = graph.near[static_cast<size_t>(i) * graph.k + j];
        if (n < 0 || label[n] == label[i] || island(n)) continue;
        if ((points[n] - points[i]).norm() > options.link * std::max(graph.spacing[i], graph.spacing[n])) continue;
        Border& border = borders[part[i]][label[n]];
        ++border.links;
        border.sum += Eigen::Map<const Eigen::Matrix<float, kSemanticChannels, 1>>(
            segmentation.attribute.data() + static_cast<size_t>(n) * kSemanticChannels);
      }
    }
    size_t moved = 0;
    std::vector<uint32_t> next = label;
    for (size_t i = 0; i < points.size(); ++i) {
      const auto at = borders.find(part[i]);
      if (at == borders.end()) continue;
      const auto& [id, border] =
          *std::max_element(at->second.begin(), at->second.end(),
                            [](const auto& a, const auto& b) { return a.second.links < b.second.links; });
      const Eigen::Matrix<float, kSemanticChannels, 1> mean = border.sum / static_cast<float>(border.links);
      std::copy_n(mean.data(), kSemanticChannels, segmentation.attribute.data() + i * kSemanticChannels);
      next[i] = id;
      ++moved;
    }
    label = next;
    changed += moved;
    if (moved == 0) break;
  }
  update_labels(segmentation);
  return changed;
}

}  // namespace pliant
