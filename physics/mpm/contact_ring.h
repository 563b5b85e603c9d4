#pragma once

#include <vector>

#include "physics/mpm/object_contact.h"

namespace pliant {

/// The nodes of one object in block n and one node around it, as far as there are blocks.
template <class T>
class NodePatch {
 public:
  NodePatch(const BlockGrid& grid, const std::vector<Node<T>>& nodes, int n);
  /// Of lane 3 at node k of the block, per cell; averaged across, or the places of single particles would make a
  /// surface bumpy.
  Vec3d gradient(int k) const;
  /// The way back to lane 3 at node k, where lanes 0 .. 2 hold the derivatives by the gradients.
  double gradient_adjoint(int k) const;
  const Node<T>& node(int k) const { return block_[13][k]; }

 private:
  template <class Visit>
  void for_neighbours(int k, Visit&& visit) const;
  const Node<T>* block_[27] = {};
};

/// The objects that have nodes at the coordinates of one block.
template <class T>
class ContactRing {
 public:
  /// Empty unless block n has siblings, the numbers of which are all higher.
  ContactRing(const StepLoads<T>& loads, const BlockGrid& grid, T dx, const std::vector<Node<T>>& nodes, int n);

  int size() const { return static_cast<int>(block_.size()); }
  int block(int a) const { return block_[a]; }
  /// Sets masses and gradients of two objects at node k; false where they do not touch.
  bool meet(int a, int b, int k, NodePair& pair) const;
  /// From the derivatives `adj` by those: adds to by_node[2] the derivatives by the gradient of the node's mass (lanes
  /// 0 .. 2) and by its mass (lane 3), and to by_density[2] those by StepLoads::density.
  void meet_adjoint(int a, int b, int k, const NodePair& adj, Node<T>* const* by_node, double* const* by_density) const;

 private:
  std::vector<int> block_;    // by object
  std::vector<double> full_;  // mass of a node in the middle of each body; 0 = not known
  std::vector<NodePatch<T>> patch_;
  double cell_;  // m^3
};

extern template class NodePatch<float>;
extern template class NodePatch<double>;
extern template class ContactRing<float>;
extern template class ContactRing<double>;

}  // namespace pliant
