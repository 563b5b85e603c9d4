#pragma once

#include "physics/mpm/mpm_data.h"
#include "physics/mpm/step_loads.h"

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
void apply_object_contact(const StepLoads<T>& loads, MpmData<T>& data, int n);

extern template void apply_object_contact(const StepLoads<float>&, MpmData<float>&, int);
extern template void apply_object_contact(const StepLoads<double>&, MpmData<double>&, int);

}  // namespace pliant
