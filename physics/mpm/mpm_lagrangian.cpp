// Nodes of Lagrangian runs: they belong to the body at rest and move with it.

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {

template <class T>
void exact_piola(StressKind kind, const T* F, T mu, T lambda, T* P) {
  static const Material kMaterial[2] = {{.law = Law::kFixedCorotated}, {.law = Law::kNeoHookean}};
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  Eigen::Map<RowMajor>{P} =
      piola_stress<T>({&kMaterial[static_cast<int>(kind)], mu, lambda}, Eigen::Map<const RowMajor>(F));
}
template void exact_piola(StressKind, const float*, float, float, float*);
template void exact_piola(StressKind, const double*, double, double, double*);

/// To what was summed over the particles comes the momentum that nodes keep, and their own part of the stabilization.
template <class T>
void Mpm<T>::add_node_momenta(int n, T dt, T* node) const {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const Vec3<T>&v = data_.node_velocity[first + k], &u = data_.node_displacement[first + k];
    const T mass = whole_ ? T(0) : node[4 * k + 3], stiffness = dt * data_.node_stabilization[first + k];
    for (int a = 0; a < 3; ++a) node[4 * k + a] += mass * v[a] - stiffness * u[a];
  }
}

template <class T>
void Mpm<T>::move_nodes(int n, T dt) {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  for (int k = 0; k < BlockGrid::kNodes; ++k) {
    const T* v = data_.node[first + k].lane;
    data_.node_velocity[first + k] = Vec3<T>(v[0], v[1], v[2]);
    data_.node_displacement[first + k] += dt * data_.node_velocity[first + k];
  }
}

/// What the particles at rest, in their order in memory, are to the nodes.
template <class T>
void Mpm<T>::find_rest_constants() {
  const size_t slots = data_.record.size();
  const T share = static_cast<T>(2 * options_.stabilization) * data_.inverse_dx * data_.inverse_dx;
  data_.rest_place.resize(4 * slots);
  for (size_t s = 0; s < slots; ++s) {
    const ParticleRecord<T>& r = data_.record[s];
    for (int a = 0; a < 3; ++a) data_.rest_place[4 * s + a] = data_.reference[r.index][a];
    data_.rest_place[4 * s + 3] = share * r.mu * r.volume;
  }
  const std::vector<Node<T>> sum = sum_over_particles(
      data_, [&](int s, T w, const Vec3<T>&, T* lane) { lane[0] += w * data_.rest_place[4 * s + 3]; });
  data_.node_stabilization.resize(sum.size());
  for (size_t i = 0; i < sum.size(); ++i) data_.node_stabilization[i] = sum[i].lane[0];
  gain_.assign(slots, Vec3<T>::Zero());
}

/// Displacements and velocities of the nodes: those of the state, or where it has none, as at a start, what the
/// particles make of them.
template <class T>
void Mpm<T>::load_nodes(const BasicSimulationState<T>& state) {
  const size_t nodes = data_.node.size();
  whole_ = state.node_velocity.empty();
  if (whole_) {
    data_.node_displacement = project_displacements(data_, state).displacement;
    data_.node_velocity.assign(nodes, Vec3<T>::Zero());
  } else {
    CHECK(state.node_velocity.size() == nodes && state.node_displacement.size() == nodes);
    data_.node_displacement = state.node_displacement;
    data_.node_velocity = state.node_velocity;
  }
  find_undisplaced();
}

/// Each particle's place and deformation gradient less what the displacements of the nodes make of them.
template <class T>
void Mpm<T>::find_undisplaced() {
  data_.undisplaced.resize(12 * data_.record.size());
  const T scale = 4 * data_.inverse_dx * data_.inverse_dx;
  for_particles(data_, data_.node_displacement, [&](int s, const AtParticle<T>& displacement) {
    const ParticleRecord<T>& r = data_.record[s];
    T* to = data_.undisplaced.data() + 12 * static_cast<size_t>(s);
    for (int a = 0; a < 3; ++a) {
      to[a] = r.x[a] - displacement.value[a];
      for (int c = 0; c < 3; ++c) to[3 + 3 * a + c] = r.F[3 * a + c] - scale * displacement.moment(a, c);
    }
  });
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
