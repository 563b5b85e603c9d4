#pragma once

#include "physics/loads/step_loads.h"
#include "physics/mpm/block_grid.h"

namespace pliant {

/// A node of the grid: momentum (after update: velocity) and mass.
template <class T>
struct alignas(4 * sizeof(T)) Node {
  T lane[4];
};

/// The first three numbers of a node, after the update its velocity [m/s]; its mass stays.
template <class T>
Vec3d velocity_of(const Node<T>& node) {
  return {node.lane[0], node.lane[1], node.lane[2]};
}
template <class T>
void set_velocity(Node<T>& node, const Vec3d& v) {
  for (int a = 0; a < 3; ++a) node.lane[a] = static_cast<T>(v[a]);
}

/// The nodes of one block, node[(i * 4 + j) * 4 + k] at first + dx * (i, j, k).
template <class T>
struct NodeBlock {
  Node<T>* node;
  Vec3d first;                              ///< m
  double dx;                                ///< m
  int object = 0;                           ///< whose nodes they are
  const Node<T>* displacement = nullptr;    ///< [64] m, in Lagrangian runs
  const T* filled = nullptr;                ///< [64] share of a cell's volume that hangs on each, likewise
  const T *low = nullptr, *high = nullptr;  ///< [3] bounds of the displacements of nodes that have mass, if known

  Vec3d rest_position(int k) const {
    constexpr int s = BlockGrid::kSide;
    return first + dx * Vec3d(k / (s * s), k / s % s, k % s);
  }
  Vec3d position(int k) const {
    const Vec3d at = rest_position(k);
    if (!displacement) return at;
    const T* u = displacement[k].lane;
    return at + Vec3d(u[0], u[1], u[2]);
  }
};

/// Nodes up to this many cells outside a pinned region stand still: a clamped node row acts about a quarter of a
/// cell behind itself, and rows are on average half a cell apart from the surface.
constexpr double kPinReach = 0.75;

/// Share of a node's spline that lies in a half space, `distance` cells above whose face the node is: the volume that
/// hangs on the node, over dx^3, when the half space is full.
double filled_share(double distance);

/// Makes the velocities of a block's nodes obey the pins and colliders of `loads`; lane 3 is the mass.
/// A node in or near a collider is held back only once as much of the body hangs on it as of one that touches the
/// surface: so contact begins when surfaces meet, wherever the nodes lie, and not a cell earlier.  What sticks or slips
/// is held until three quarters of that are gone.  How much it is tells NodeBlock::filled; without it, mass over the
/// mean density of the object, by which light parts of an uneven body touch late.  Colliders act on nodes where they
/// are now; pins in Lagrangian runs on those that were in the region at rest, so that nothing else sticks to them.
/// `impulse`, if given, has room for one vector per collider and one per pin, to which the momentum [N s] given to the
/// nodes is added.
template <class T>
void apply_node_conditions(const StepLoads<T>& loads, const NodeBlock<T>& block, Vec3d* impulse = nullptr);
/// `block` holds the velocities from before; `adj` [64] the derivatives of a scalar with respect to the velocities
/// after the conditions, and on return with respect to those before.  Adds to `by_displacement` [64], if given, those
/// with respect to the displacements, with which normals and velocities of surfaces change.  Masses and which nodes
/// touch what are taken as constant.
template <class T>
void apply_node_conditions_adjoint(const StepLoads<T>& loads, const NodeBlock<T>& block, Node<T>* adj,
                                   Vec3<T>* by_displacement = nullptr);

extern template void apply_node_conditions(const StepLoads<float>&, const NodeBlock<float>&, Vec3d*);
extern template void apply_node_conditions(const StepLoads<double>&, const NodeBlock<double>&, Vec3d*);
extern template void apply_node_conditions_adjoint(const StepLoads<float>&, const NodeBlock<float>&, Node<float>*,
                                                   Vec3<float>*);
extern template void apply_node_conditions_adjoint(const StepLoads<double>&, const NodeBlock<double>&, Node<double>*,
                                                   Vec3<double>*);

}  // namespace pliant
