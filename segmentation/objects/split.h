#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/graph/gaussian_graph.h"

namespace pliant {

/// How one object falls into several.
struct SplitOptions {
  int neighbours = 10;  ///< of the graph in which parts are connected
  float link = 0.2f;    ///< least nearness of neighbours in one part, see GaussianGraph::edge_nearness
  float crumb = 0.03f;  ///< a part with less than this share of the object's opacity goes to the nearest larger one
  float ends = 0.1f;    ///< share of a connected object's Gaussians that is fixed at either end when it is cut in two
  GraphCutOptions cut;
};

struct SplitResult {
  std::vector<int> part;  ///< [N] of the members, 0 = the one with most opacity; -1 = not a member
  int parts = 0;
  bool cut = false;      ///< the object hangs together and was cut by colour and distance
  double cut_share = 0;  ///< then: largest share of a part's ties that the cut goes through
};

/// Parts of the Gaussians with `member` [N] != 0: those that lie apart, else those that sharp changes of colour part,
/// else the two sides of the minimum cut between the ends that are farthest from each other over paths on which
/// distance and changes of colour count.
SplitResult split_object(const SplitOptions& options, const GaussianCloud& cloud, std::span<const uint8_t> member);

}  // namespace pliant
