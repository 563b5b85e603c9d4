// What Lagrangian runs do with their nodes when a state is loaded, backwards.

#include "gaussians/base/error.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {

template <class T>
void StepAdjoint<T>::load_node_gradient(const StateGradient<T>& gradient, size_t nodes) {
  const auto load = [&](const std::vector<Vec3<T>>& from, std::vector<Vec3<T>>& to) {
    CHECK(from.empty() || from.size() == nodes);
    if (from.empty())
      to.assign(nodes, Vec3<T>::Zero());
    else
      to = from;
  };
  load(gradient.node_velocity, adj_velocity_);
  load(gradient.node_displacement, adj_displacement_);
  momentum_sum_.assign(nodes, Vec3<T>::Zero());
  if (adj_stabilization_.size() != nodes) adj_stabilization_.assign(nodes, T(0));
}

/// `Mpm::load_nodes` backwards.
template <class T>
void StepAdjoint<T>::reverse_load_nodes(const BasicSimulationState<T>& state, StateGradient<T>& gradient) {
  reverse_undisplaced();
  gradient.node_displacement.clear();
  gradient.node_velocity.clear();
  if (state.node_velocity.empty()) {
    reverse_projection(state);
  } else {
    gradient.node_displacement = adj_displacement_;
    gradient.node_velocity = adj_velocity_;
  }
}

/// The particles' part of the stabilization is read of x and F less `undisplaced`, so that it depends on what the
/// nodes' displacement was at the start, not on x and F then.
template <class T>
void StepAdjoint<T>::reverse_undisplaced() {
  const T scale = 4 * solver_.inverse_dx * solver_.inverse_dx;
  std::vector<AtParticle<T>> by(record_.size());
  for_particles(solver_, momentum_sum_, [&](int s, const AtParticle<T>& sum) {
    const T stiffness = solver_.rest_place[4 * static_cast<size_t>(s) + 3];
    by[s] = {stiffness * sum.value, stiffness * sum.moment};
    AdjointRecord<T>& r = record_[slot_[solver_.record[s].index]];
    for (int a = 0; a < 3; ++a) {
      r.x[a] -= by[s].value[a];
      for (int c = 0; c < 3; ++c) r.F[3 * a + c] -= by[s].moment(a, c);
    }
  });
  const std::vector<Node<T>> sums = sum_over_particles(solver_, [&](int s, T w, const Vec3<T>& d, T* lane) {
    const Vec3<T> at_node = w * (by[s].value + scale * by[s].moment * d);
    for (int a = 0; a < 3; ++a) lane[a] += at_node[a];
  });
  for (size_t i = 0; i < sums.size(); ++i)
    adj_displacement_[i] += Vec3<T>(sums[i].lane[0], sums[i].lane[1], sums[i].lane[2]);
}

/// `project_displacements` backwards.
template <class T>
void StepAdjoint<T>::reverse_projection(const BasicSimulationState<T>& state) {
  const ProjectedDisplacements<T> projected = project_displacements(solver_, state);
  // By the sums of mass times displacement, and in `by_mass` by the mass.
  std::vector<Vec3<T>> by_sum(projected.mass.size(), Vec3<T>::Zero()), by_mass = by_sum;
  for (size_t i = 0; i < by_sum.size(); ++i) {
    if (!(projected.mass[i] > T(0))) continue;
    by_sum[i] = adj_displacement_[i] / projected.mass[i];
    by_mass[i][0] = -by_sum[i].dot(projected.displacement[i]);
  }
  for_particles(solver_, by_mass, [&](int s, const AtParticle<T>& by) {
    record_[slot_[solver_.record[s].index]].by_mass += by.value[0];
  });
  for_particles(solver_, by_sum, [&](int s, const AtParticle<T>& by) {
    const int i = solver_.record[s].index;
    AdjointRecord<T>& r = record_[slot_[i]];
    const Mat3<T> strain = state.F[i] - Mat3<T>::Identity();
    r.by_mass += by.value.dot(state.x[i] - solver_.reference[i]) + by.moment.cwiseProduct(strain).sum();
    for (int a = 0; a < 3; ++a) {
      r.x[a] += r.mass * by.value[a];
      for (int c = 0; c < 3; ++c) r.F[3 * a + c] += r.mass * by.moment(a, c);
    }
  });
}

/// The stabilization of nodes is the sum over w times that of the particles, which is so much of mu.
template <class T>
void StepAdjoint<T>::add_by_stabilization(std::vector<T>& by_mu) const {
  std::vector<Vec3<T>> by_node(adj_stabilization_.size(), Vec3<T>::Zero());
  for (size_t i = 0; i < by_node.size(); ++i) by_node[i][0] = adj_stabilization_[i];
  for_particles(solver_, by_node, [&](int s, const AtParticle<T>& by) {
    const ParticleRecord<T>& r = solver_.record[s];
    by_mu[r.index] += by.value[0] * solver_.rest_place[4 * static_cast<size_t>(s) + 3] / r.mu;
  });
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
