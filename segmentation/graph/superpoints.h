#pragma once

#include <vector>

#include "segmentation/graph/gaussian_graph.h"

namespace pliant {

/// Parts of a graph of Gaussians, each of nodes that are alike and lie against each other, and the graph that they
/// make.
struct Superpoints {
  std::vector<int> part;             ///< [nodes] of every node
  std::vector<Vec3f> lab;            ///< [parts] mean, weighted by opacity
  std::vector<float> opacity;        ///< [parts] sum
  std::vector<CutEdge> edges;        ///< between parts; weights are sums over the edges between their nodes
  std::vector<float> edge_nearness;  ///< [edges] sums, see GaussianGraph
  std::vector<int> edge_of;          ///< [edges of the graph] the edge of the parts that holds it; -1 inside a part

  size_t size() const { return lab.size(); }
};

/// Joins nodes along edges of descending weight into parts of at most `most` nodes.
Superpoints superpoints(const GaussianGraph& graph, int most);

}  // namespace pliant
