#pragma once

#include "physics/mpm/node_conditions.h"
#include "physics/mpm/step_adjoint.h"

namespace pliant {

/// Turns derivatives by the velocities of a block's nodes after the conditions (in `adj`) into those by their momentum
/// and mass, and adds those by gravity and the velocity scale.
template <class T>
void reverse_node_update(const MpmKernels<T>& forward, T dt, const StepLoads<T>& loads, const NodeBlock<T>& adj, const Node<T>* sums,
                         StepLoadsGradient& by_loads);

/// The same for v = momentum / mass of [64] nodes, from their velocities and masses.
template <class T>
void reverse_node_average(const Node<T>* velocity, Node<T>* adj);

extern template void reverse_node_average(const Node<float>*, Node<float>*);
extern template void reverse_node_average(const Node<double>*, Node<double>*);
extern template void reverse_node_update(const MpmKernels<float>&, float, const StepLoads<float>&,
                                         const NodeBlock<float>&, const Node<float>*, StepLoadsGradient&);
extern template void reverse_node_update(const MpmKernels<double>&, double, const StepLoads<double>&,
                                         const NodeBlock<double>&, const Node<double>*, StepLoadsGradient&);

}  // namespace pliant
