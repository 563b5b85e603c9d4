#include "physics/mpm/adjoint/node_update_adjoint.h"

namespace pliant {

template <class T>
void reverse_node_update(T dt, const StepLoads<T>& loads, const Node<T>* sums, Node<T>* adj,
                         StepLoadsGradient& by_loads) {
  const T scale = loads.velocity_scale;
  Vec3d by_gravity = Vec3d::Zero();
  double by_scale = 0;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T mass = sums[k].lane[3];
    T* g = adj[k].lane;
    if (!(mass > T(0))) {
      g[0] = g[1] = g[2] = g[3] = 0;
      continue;
    }
    const T inverse = 1 / mass;
    T by_mass = 0;
    for (int a = 0; a < 3; ++a) {
      const T v = sums[k].lane[a] * inverse;
      by_scale += g[a] * (v + dt * loads.gravity[a]);
      g[a] *= scale;
      by_gravity[a] += g[a];
      g[a] *= inverse;
      by_mass -= g[a] * v;
    }
    g[3] = by_mass;
  }
  by_loads.gravity += static_cast<double>(dt) * by_gravity;
  by_loads.velocity_scale += by_scale;
}

template <class T>
void reverse_node_average(const Node<T>* velocity, Node<T>* adj) {
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T* v = velocity[k].lane;
    T* g = adj[k].lane;
    const T inverse = v[3] > T(0) ? 1 / v[3] : T(0);
    for (int a = 0; a < 3; ++a) g[a] *= inverse;
    g[3] = -(g[0] * v[0] + g[1] * v[1] + g[2] * v[2]);
  }
}

template void reverse_node_average(const Node<float>*, Node<float>*);
template void reverse_node_average(const Node<double>*, Node<double>*);
template void reverse_node_update(float, const StepLoads<float>&, const Node<float>*, Node<float>*, StepLoadsGradient&);
template void reverse_node_update(double, const StepLoads<double>&, const Node<double>*, Node<double>*,
                                  StepLoadsGradient&);

}  // namespace pliant
