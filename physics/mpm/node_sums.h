#pragma once

#include <algorithm>
#include <vector>

#include "physics/mpm/block_grid.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/mpm_data.h"
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

/// The same of a Lagrangian run, of the nodes that particles reach.
template <class T>
Node<T>* sum_pairs(const MpmKernels<T>& kernels, const MpmData<T>& data, int n, const std::vector<Node<T>>& patches,
                   std::vector<Node<T>>& nodes) {
  Node<T>* node = nodes.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
  std::fill_n(node, BlockGrid::kNodes, Node<T>{});
  const auto add = [&](const std::array<int, 8>& sources) {
    for (int o = 0; o < 8; ++o) {
      if (sources[o] < 0) continue;
      const size_t list = 8 * static_cast<size_t>(sources[o]) + o;
      kernels.add_pairs(data.pair.data() + data.pair_begin[list], data.pair_begin[list + 1] - data.pair_begin[list],
                        patches[static_cast<size_t>(sources[o]) * BlockGrid::kPatchNodes].lane, node->lane);
    }
  };
  add(data.grid.sources_of(n));
  for (const std::array<int, 8>& more : data.grid.further_sources_of(n)) add(more);
  return node;
}

}  // namespace pliant
