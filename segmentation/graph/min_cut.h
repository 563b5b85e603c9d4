#pragma once

#include <cstdint>
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

}  // namespace pliant
