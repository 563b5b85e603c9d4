#include "segmentation/graph/min_cut.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

constexpr double kUnit = 4096;  // steps in which gains and weights are counted

}  // namespace

std::vector<uint8_t> min_cut(std::span<const float> gain, std::span<const CutEdge> edges) {
  std::vector<uint8_t> label(gain.size());
  for (size_t i = 0; i < gain.size(); ++i) label[i] = gain[i] > 0;
  // Whole numbers: rounding would leave crumbs of capacity, and the search would carry each of them.
  const auto whole = [](float value) { return static_cast<int64_t>(std::llround(static_cast<double>(value) * kUnit)); };
  cv::detail::GCGraph<int64_t> graph(static_cast<unsigned>(gain.size()), static_cast<unsigned>(2 * edges.size()));
  for (float g : gain) graph.addTermWeights(graph.addVtx(), g > 0 ? whole(g) : 0, g < 0 ? whole(-g) : 0);
  bool connected = false;
  for (const CutEdge& edge : edges) {
    CHECK(edge.weight >= 0 && edge.a >= 0 && edge.b >= 0 && edge.a < static_cast<int>(gain.size()) &&
          edge.b < static_cast<int>(gain.size()));
    const int64_t capacity = whole(edge.weight);
    if (edge.a == edge.b || capacity == 0) continue;
    graph.addEdges(edge.a, edge.b, capacity, capacity);
    connected = true;
  }
  if (!connected) return label;
  graph.maxFlow();
  for (size_t i = 0; i < gain.size(); ++i) label[i] = graph.inSourceSegment(static_cast<int>(i));
  return label;
}

}  // namespace pliant
