#include "segmentation/lift/min_cut.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>

#include "gaussians/base/error.h"

namespace pliant {

std::vector<uint8_t> min_cut(std::span<const float> gain, std::span<const CutEdge> edges) {
  std::vector<uint8_t> label(gain.size());
  for (size_t i = 0; i < gain.size(); ++i) label[i] = gain[i] > 0;
  cv::detail::GCGraph<double> graph(static_cast<unsigned>(gain.size()), static_cast<unsigned>(2 * edges.size()));
  for (float g : gain) graph.addTermWeights(graph.addVtx(), g > 0 ? g : 0.0, g < 0 ? -g : 0.0);
  bool connected = false;
  for (const CutEdge& edge : edges) {
    CHECK(edge.weight >= 0 && edge.a >= 0 && edge.b >= 0 && edge.a < static_cast<int>(gain.size()) && edge.b < static_cast<int>(gain.size()));
    if (edge.a == edge.b || edge.weight == 0) continue;
    graph.addEdges(edge.a, edge.b, edge.weight, edge.weight), connected = true;
  }
  if (!connected) return label;
  graph.maxFlow();
  for (size_t i = 0; i < gain.size(); ++i) label[i] = graph.inSourceSegment(static_cast<int>(i));
  return label;
}

}  // namespace pliant
