#pragma once

#include "physics/mpm/node_conditions.h"
#include "physics/mpm/step_adjoint.h"

namespace pliant {

/// Velocities of a block's nodes before the conditions: v = (momentum / mass + dt g) scale, as `Mpm` computes them; the
/// fourth lane keeps the mass.
template <class T>
void node_velocities(T dt, const StepLoads<T>& loads, const Node<T>* sums, Node<T>* velocity);

/// Turns derivatives by the velocities of a block's nodes after the conditions (in `adj`) into those by their momentum
/// and mass, and adds those by gravity and the velocity scale.
template <class T>
void reverse_node_update(T dt, const StepLoads<T>& loads, const NodeBlock<T>& adj, const Node<T>* sums,
                         StepLoadsGradient& by_loads);

extern template void node_velocities(float, const StepLoads<float>&, const Node<float>*, Node<float>*);
extern template void node_velocities(double, const StepLoads<double>&, const Node<double>*, Node<double>*);
extern template void reverse_node_update(float, const StepLoads<float>&, const NodeBlock<float>&, const Node<float>*,
                                         StepLoadsGradient&);
extern template void reverse_node_update(double, const StepLoads<double>&, const NodeBlock<double>&,
                                         const Node<double>*, StepLoadsGradient&);

}  // namespace pliant
