#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace pliant {

/// A pair of nodes that costs `weight` >= 0 when their labels differ.
struct CutEdge {
  int a = 0, b = 0;
  float weight = 0;
};

/// Labels x [N] in {0, 1} that minimise  -sum_i gain_i x_i + sum_edges weight |x_a - x_b|  by maximum flow
/// (Greig, Porteous and Seheult 1989; Boykov and Kolmogorov 2004).  Gains and weights
/// are rounded to 1/4096; beyond that the minimum is exact.
std::vector<uint8_t> min_cut(std::span<const float> gain, std::span<const CutEdge> edges);

/// The same for one graph and gains that change: each cut goes on from the flow of the one before (Kohli and Torr
/// 2007), which takes a fraction of the time where the gains are much the same.
class MinCut {
 public:
  MinCut(size_t nodes, std::span<const CutEdge> edges);
  ~MinCut();
  std::vector<uint8_t> labels(std::span<const float> gain);

 private:
  struct Flow;
  std::unique_ptr<Flow> flow_;
};

}  // namespace pliant
