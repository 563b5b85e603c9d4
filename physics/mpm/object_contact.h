#pragma once

#include <vector>

#include "physics/mpm/node_conditions.h"

namespace pliant {

/// Two bodies at a node.
struct NodePair {
  double mass[2];     ///< kg
  Vec3d velocity[2];  ///< m/s
  Vec3d gradient[2];  ///< of the share of space that each fills; points into the body
};

/// Bodies that approach exchange an impulse along the normal n = (grad_1 - grad_0) / |..| that leaves them with one
/// normal velocity, and Coulomb friction across it; bodies that part are left alone.  What one gains the other loses.
/// (Bardenhagen, Guilkey, Roessig, Brackbill, Witzel, Foster 2001.)
void exchange_impulse(double friction, NodePair& pair);
/// `pair` as it was before; `adj` holds the derivatives with respect to the velocities after (the rest zero), and on
/// return those with respect to masses, velocities and gradients before.
void exchange_impulse_adjoint(double friction, const NodePair& pair, NodePair& adj);

/// Contact between the objects that have node block n or a sibling of it at its coordinates, for all nodes of the
/// ring; a no-op unless n is the ring's lowest number.  Between the update of all nodes and the node conditions.  Two
/// bodies touch at a node where they fill the space together but for a fifth of a cell.
template <class T>
void apply_object_contact(const StepLoads<T>& loads, const BlockGrid& grid, T dx, std::vector<Node<T>>& nodes, int n);

/// Derivatives in the reverse direction, for all node blocks.
template <class T>
struct ContactGradient {
  std::vector<Node<T>>& velocity;  ///< by the velocities after; on return, by those before
  std::vector<Node<T>>& mass;      ///< added to: by the gradient of the nodes' mass (lanes 0 .. 2) and by their mass
  std::vector<double>& density;    ///< [node blocks] added to: by the density of the block's object
};
/// `before` holds velocities and masses before the contact.  Touches only what belongs to the ring of block n.
template <class T>
void apply_object_contact_adjoint(const StepLoads<T>& loads, const BlockGrid& grid, T dx,
                                  const std::vector<Node<T>>& before, int n, ContactGradient<T> adj);
/// After that was done for all blocks: adds to lane 3 of adj [64] the derivatives by the masses of block n.
template <class T>
void add_contact_masses(const BlockGrid& grid, const std::vector<Node<T>>& by_mass, int n, Node<T>* adj);

}  // namespace pliant
