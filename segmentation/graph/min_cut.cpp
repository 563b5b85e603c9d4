#include "segmentation/graph/min_cut.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kUnit = 4096;  // steps in which gains and weights are counted

/// Whole numbers: rounding would leave crumbs of capacity, and the search would carry each of them.
int64_t whole(float value) { return std::llround(static_cast<double>(value) * kUnit); }

}  // namespace

struct MinCut::Flow {
  std::vector<int64_t> gain;
  cv::detail::GCGraph<int64_t> graph;
  bool connected = false;
};

MinCut::MinCut(size_t nodes, std::span<const CutEdge> edges)
    : flow_(new Flow{std::vector<int64_t>(nodes, 0),
                     {static_cast<unsigned>(nodes), static_cast<unsigned>(2 * edges.size())}}) {
  for (size_t i = 0; i < nodes; ++i) flow_->graph.addVtx();
  for (const CutEdge& e : edges) {
    CHECK(e.weight >= 0 && e.a >= 0 && e.b >= 0 && e.a < static_cast<int>(nodes) && e.b < static_cast<int>(nodes));
    const int64_t capacity = whole(e.weight);
    if (e.a == e.b || capacity == 0) continue;
    flow_->graph.addEdges(e.a, e.b, capacity, capacity);
    flow_->connected = true;
  }
}

MinCut::~MinCut() = default;

std::vector<uint8_t> MinCut::labels(std::span<const float> gain) {
  CHECK(gain.size() == flow_->gain.size());
  std::vector<uint8_t> label(gain.size());
  // The change of a gain is added to what the flow so far has left of it.
  for (size_t i = 0; i < gain.size(); ++i) {
    label[i] = gain[i] > 0;
    const int64_t more = whole(gain[i]) - flow_->gain[i];
    flow_->graph.addTermWeights(static_cast<int>(i), std::max<int64_t>(more, 0), std::max<int64_t>(-more, 0));
    flow_->gain[i] += more;
  }
  if (!flow_->connected) return label;
  flow_->graph.maxFlow();
  for (size_t i = 0; i < gain.size(); ++i) label[i] = flow_->graph.inSourceSegment(static_cast<int>(i));
  return label;
}

std::vector<uint8_t> min_cut(std::span<const float> gain, std::span<const CutEdge> edges) {
  return MinCut(gain.size(), edges).labels(gain);
}

}  // namespace pliant
