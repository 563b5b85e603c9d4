#pragma once

#include "physics/mpm/adjoint/step_adjoint.h"

namespace pliant {

/// Turns derivatives by the updated velocities of a block's nodes into those by their momentum and mass, which were
/// `sums`, and adds those by gravity and the velocity scale.
template <class T>
void reverse_node_update(T dt, const StepLoads<T>& loads, const Node<T>* sums, Node<T>* adj,
                         StepLoadsGradient& by_loads);

/// The same for v = momentum / mass of [64] nodes, from their velocities and masses.
template <class T>
void reverse_node_average(const Node<T>* velocity, Node<T>* adj);

extern template void reverse_node_average(const Node<float>*, Node<float>*);
extern template void reverse_node_average(const Node<double>*, Node<double>*);
extern template void reverse_node_update(float, const StepLoads<float>&, const Node<float>*, Node<float>*,
                                         StepLoadsGradient&);
extern template void reverse_node_update(double, const StepLoads<double>&, const Node<double>*, Node<double>*,
                                         StepLoadsGradient&);

}  // namespace pliant
