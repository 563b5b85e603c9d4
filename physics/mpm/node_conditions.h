#pragma once

#include "physics/mpm/block_grid.h"
#include "physics/mpm/step_loads.h"

namespace pliant {

/// A node of the grid: momentum (after update: velocity) and mass.
template <class T>
struct alignas(4 * sizeof(T)) Node {
  T lane[4];
};

/// The nodes of one block, node[(i * 4 + j) * 4 + k] at first + dx * (i, j, k).
template <class T>
struct NodeBlock {
  Node<T>* node;
  Vec3d first;  ///< m
  double dx;    ///< m

  Vec3d position(int k) const {
    constexpr int s = BlockGrid::kSide;
    return first + dx * Vec3d(k / (s * s), k / s % s, k % s);
  }
};

/// Nodes up to this many cells outside a pinned region stand still: a clamped node row acts about a quarter of a
/// cell behind itself, and rows are on average half a cell apart from the surface.
constexpr double kPinReach = 0.75;

/// Makes the velocities of a block's nodes obey the pins and obstacles of `loads`.
template <class T>
void apply_node_conditions(const StepLoads<T>& loads, const NodeBlock<T>& block);

extern template void apply_node_conditions(const StepLoads<float>&, const NodeBlock<float>&);
extern template void apply_node_conditions(const StepLoads<double>&, const NodeBlock<double>&);

}  // namespace pliant
