#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/graph/color_model.h"
#include "segmentation/graph/min_cut.h"

namespace pliant {

/// Which Gaussians lie against each other and how alike they are.
struct GaussianGraph {
  std::vector<int> nodes;              ///< Gaussians of the graph, ascending
  std::vector<CutEdge> edges;          ///< between places in `nodes`; weights in [0, 1]
  std::vector<CutEdge> border;         ///< a: place in `nodes`, b: Gaussian outside the graph
  std::vector<float> edge_nearness;    ///< [edges] the weight without its first factor, the likeness of colours
  std::vector<float> border_nearness;  ///< [border]
  std::vector<Vec3f> lab;              ///< of every node, see lab_of_rgb
  std::vector<float> opacity;          ///< of every node
  std::vector<Vec3f> outside_lab;      ///< an even choice of what lies outside the graph
  std::vector<float> outside_opacity;
  float spacing = 0;  ///< median distance to the fifth neighbour (scene units)
};

/// The edges at every node.
struct Adjacency {
  std::vector<int> start;  ///< [nodes + 1] where those of a node begin
  std::vector<int> to;     ///< node at the other end
  std::vector<int> edge;   ///< place among the edges

  Adjacency() = default;
  Adjacency(size_t nodes, std::span<const CutEdge> edges);
};

/// Graph of the Gaussians with `member` != 0 and their `neighbours` nearest ones.  Weight of an edge, with d the
/// distance of the centres, r the largest standard deviation and o the opacity:
///   exp(-min(dRGB^2 / (4 median dRGB^2), 20)) exp(-(d / max(2 spacing, r_i + r_j))^2 / 2) sqrt(o_i o_j).
GaussianGraph gaussian_graph(const GaussianCloud& cloud, std::span<const uint8_t> member, int neighbours);

struct GraphCutOptions {
  float smoothness = 4;             ///< factor on the weights of edges
  float color = 1, color_clip = 4;  ///< weight and bound of the log ratio of the colour models
  float outside = 0;                ///< share of the background's colour model that what lies outside the graph makes
  int rounds = 5;                   ///< of colour models and cut; ends early when nothing moves
  ColorModelOptions model;
};

/// Labels of the nodes: evidence (log odds, [nodes]) plus the ratio of colour models of the two sides, which starts
/// from `label` and is learned anew in every round; what lies outside the graph is background.
void cut_graph(const GraphCutOptions& options, const GaussianGraph& graph, std::span<const float> evidence,
               std::vector<uint8_t>& label);

/// Parts of label 1 that are connected over edges above `link`: [nodes] number of the part, -1 for label 0; part 0 is
/// the one with the largest sum of opacity.  `nearness` = by nearness alone, whatever the colours.
std::vector<int> connected_parts(const GaussianGraph& graph, const std::vector<uint8_t>& label, float link,
                                 bool nearness = false);

/// Flags [parts] of the parts that belong to those in `wanted` [parts] although their colours part them: they lie
/// against wanted parts more than twice as much as against nodes of label 0 and what lies outside the graph.
std::vector<uint8_t> attached_parts(const GaussianGraph& graph, const std::vector<int>& part,
                                    std::vector<uint8_t> wanted);

/// Nodes of label 0 that touch nothing but the object: parts, connected by nearness, that hold at least `least` of the
/// object's opacity and whose ties to what lies outside the graph are below `touch` of their own opacity; `outside`
/// [nodes] times its own is that of a node, and infinite for one whose whole part stays away.
std::vector<int> enclosed_nodes(const GaussianGraph& graph, const std::vector<uint8_t>& label,
                                const std::vector<float>& outside, float link, float least, float touch);

/// Share of the nearness at nodes of label 1 that ties them to nodes of label 0 (1 where nothing is labelled).
float tied_share(const GaussianGraph& graph, const std::vector<uint8_t>& label);

/// Order of nodes by the length of the shortest path from `sources`, edge length 0.1 - log weight; nodes that no path
/// of at most `limit` reaches are left out.  `length` receives the paths [nodes], infinite for these.
std::vector<int> order_from(const Adjacency& adjacency, std::span<const CutEdge> edges, const std::vector<int>& sources,
                            std::vector<float>* length = nullptr, float limit = INFINITY);
std::vector<int> order_from(const GaussianGraph& graph, const std::vector<int>& sources,
                            std::vector<float>* length = nullptr);

/// The same without the nodes whose path from `rivals` is shorter than `share` of that from `sources`.
std::vector<int> order_apart(const Adjacency& adjacency, std::span<const CutEdge> edges,
                             const std::vector<int>& sources, const std::vector<int>& rivals, float share);

/// How many of the first nodes of `order` are cut off best: least ratio of the weight of edges that leave them to the
/// weight of edges at them (conductance of a sweep cut; Andersen, Chung and Lang 2006).  At least `fewest`, at most
/// half the nodes.  `inner` [nodes] is the weight of edges inside each node, where nodes are groups; it may be empty.
size_t best_sweep(const Adjacency& adjacency, std::span<const CutEdge> edges, std::span<const double> inner,
                  const std::vector<int>& order, size_t fewest);

}  // namespace pliant
