#pragma once

#include <algorithm>
#include <vector>

#include "physics/mpm/block_grid.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/node_conditions.h"

namespace pliant {

/// What the patches [particle blocks, 6, 6, 6] around node block n say of it, summed in a fixed order into `nodes`.
template <class T>
Node<T>* sum_patches(const MpmKernels<T>& kernels, const BlockGrid& grid, int n, const std::vector<Node<T>>& patches,
                     std::vector<Node<T>>& nodes) {
  Node<T>* node = nodes.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  std::fill_n(node, BlockGrid::kNodes, Node<T>{});
  const auto add = [&](const std::array<int, 8>& sources) {
    const T* patch[8];
    for (int o = 0; o < 8; ++o)
      patch[o] = sources[o] < 0 ? nullptr : patches[static_cast<size_t>(sources[o]) * BlockGrid::kPatchNodes].lane;
    kernels.add_nodes(patch, node->lane);
  };
  add(grid.sources_of(n));
  for (const std::array<int, 8>& more : grid.further_sources_of(n)) add(more);
  return node;
}

}  // namespace pliant
