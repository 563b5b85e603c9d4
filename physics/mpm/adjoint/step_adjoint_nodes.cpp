// Lagrangian runs backwards.  Their state is that of the nodes; derivatives by particles wait in the records until they
// are added to those by the nodes that the particles follow.

#include <algorithm>

#include "gaussians/base/error.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/node_sums.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {
namespace {

template <class T>
void exact_piola_adjoint(StressKind kind, const T* F, T mu, T lambda, const T* adj_P, T* by_F, T* by_lame) {
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  const LawGradient<T> g = piola_stress_adjoint<T>({&plain_material(kind), mu, lambda}, Eigen::Map<const RowMajor>(F),
                                                   Eigen::Map<const RowMajor>(adj_P));
  Eigen::Map<RowMajor>{by_F} = g.F;
  by_lame[0] = g.mu;
  by_lame[1] = g.lambda;
}

}  // namespace

template <class T>
void StepAdjoint<T>::load_node_gradient(const StateGradient<T>& gradient, const TapeStep<T>& last) {
  const size_t nodes = last.node_velocity.size(), blocks = last.grid->particle_blocks();
  const auto load = [&](const std::vector<Vec3<T>>& from, std::vector<Vec3<T>>& to) {
    CHECK(from.empty() || from.size() == nodes);
    if (from.empty())
      to.assign(nodes, Vec3<T>::Zero());
    else
      to = from;
  };
  load(gradient.node_velocity, adj_velocity_);
  load(gradient.node_displacement, adj_displacement_);
  if (nodes == 0) return;
  adj_undisplaced_.assign(solver_.undisplaced.size(), T(0));
  if (adj_stabilization_.size() != nodes) adj_stabilization_.assign(nodes, T(0));
  if (adj_damping_.size() != solver_.node_damping.size()) adj_damping_.assign(solver_.node_damping.size(), T(0));
  patch_.assign(blocks * BlockGrid::kPatchNodes, Node<T>{});
  old_patch_.assign(patch_.size(), Node<T>{});
  followed_.assign(blocks, 1);
  by_gain_.resize(3 * record_.size());
  where_.resize(record_.size());
  moving_.resize(record_.size());
  contacts_.clear();
}

template <class T>
ElasticAdjointRun<T> StepAdjoint<T>::elastic_run(const TapeStep<T>& step, int b) const {
  ElasticAdjointRun<T> in{};
  in.run = run_of_block(solver_, b, step.node_displacement, step.node_velocity);
  in.run.dt = step.dt;
  in.run.viscosity_time = step.loads.viscosity_time;
  in.run.viscous = viscous_ || step.loads.viscosity_time > T(0);
  in.run.exact_piola = exact_piola<T>;
  in.exact_piola_adjoint = exact_piola_adjoint<T>;
  return in;
}

/// To the derivatives by the nodes come those by the particles that follow them, where there are any.
template <class T>
void StepAdjoint<T>::reverse_follow(const TapeStep<T>& step, int b) {
  if (!followed_[b]) return;
  followed_[b] = 0;
  const size_t begin = static_cast<size_t>(step.begin[b]), patch = static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  AdjointRecord<T>* record = record_.data() + begin;
  kernels_.follow_nodes(elastic_run(step, b).run, record, patch_[patch].lane, old_patch_[patch].lane);
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s, ++record) {
    if (!adj_undisplaced_.empty())
      for (int k = 0; k < 12; ++k)
        adj_undisplaced_[12 * static_cast<size_t>(s) + k] += k < 3 ? record->x[k] : record->F[k - 3];
    std::fill_n(record->x, 3, T(0));
    std::fill_n(record->F, 9, T(0));
    std::fill_n(record->v, 3, T(0));
    std::fill_n(record->C, 9, T(0));
  }
}

/// u' = u + dt v' backwards, from the derivatives by u' and v' after those of the step that comes next are summed.
template <class T>
void StepAdjoint<T>::reverse_displacement(const TapeStep<T>& step, int n) {
  sum_node_gradient(*step.grid, n);
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  for (size_t at = first; at < first + BlockGrid::kNodes; ++at)
    for (int a = 0; a < 3; ++a) adj_node_[at].lane[a] = adj_velocity_[at][a] + step.dt * adj_displacement_[at][a];
}

template <class T>
void StepAdjoint<T>::sum_node_gradient(const BlockGrid& grid, int n) {
  const auto add = [&](const std::vector<Node<T>>& patches, std::vector<Vec3<T>>& to) {
    const Node<T>* sum = sum_patches(forward_, grid, n, patches, adj_node_);
    for (int k = 0; k < BlockGrid::kNodes; ++k) to[static_cast<size_t>(n) * BlockGrid::kNodes + k] += three(sum[k]);
  };
  add(patch_, adj_displacement_);
  add(old_patch_, adj_velocity_);
}

/// v' = (k v + f / m + dt g) scale backwards, f the impulse and k what damping keeps; and what nodes say of their own
/// stabilization.
template <class T>
void StepAdjoint<T>::reverse_push(const TapeStep<T>& step, int n) {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  const T scale = step.loads.velocity_scale;
  Vec3d by_gravity = Vec3d::Zero();
  double by_scale = 0;
  for (size_t at = first; at < first + BlockGrid::kNodes; ++at) {
    T* adj = adj_node_[at].lane;
    const T mass = step.node_velocity[at].lane[3], kept = kept_.empty() ? T(1) : kept_[at];
    if (!(mass > T(0))) {
      adj_node_[at] = {};
      adj_velocity_[at].setZero();
      continue;
    }
    const Vec3<T> by(adj[0], adj[1], adj[2]), v = three(step.node_velocity[at]), impulse = three(step.node[at]);
    by_scale += static_cast<double>(by.dot(kept * v + impulse / mass + step.dt * step.loads.gravity));
    const Vec3<T> by_sum = scale * by, by_impulse = by_sum / mass;
    by_gravity += by_sum.template cast<double>();
    adj_velocity_[at] = kept * by_sum;
    if (!adj_damping_.empty()) adj_damping_[at] -= step.dt * kept * by_sum.dot(v);
    adj_stabilization_[at] -= step.dt * three(step.node_displacement[at]).dot(by_impulse);
    for (int a = 0; a < 3; ++a) adj[a] = by_impulse[a];
    adj[3] = -by_impulse.dot(impulse) / mass;
  }
  node_sums_[n].gravity += static_cast<double>(step.dt) * by_gravity;
  node_sums_[n].velocity_scale += by_scale;
}

/// `Mpm::elastic_block` backwards.
template <class T>
void StepAdjoint<T>::reverse_impulses(const TapeStep<T>& step, int b) {
  alignas(64) Node<T> adj[BlockGrid::kPatchNodes];
  collect_patch(*step.grid, b, adj_node_, adj);
  const size_t begin = static_cast<size_t>(step.begin[b]), patch = static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  ElasticAdjointRun<T> in = elastic_run(step, b);
  AdjointRecord<T>* record = record_.data() + begin;
  const bool loaded =
      !step.loads.body.empty() && std::any_of(record, record + in.run.count, [](const auto& r) { return r.bits != 0; });
  const bool touches = step.touching && contacts_.block_touches()[b];
  std::vector<TapeParticle<T>> now;
  std::vector<T> gain;
  if (loaded || touches) {
    now.resize(in.run.count);
    forward_.follow_nodes(in.run, Follow::kBoth, now.data());
    gain = gains(step, b, now.data());
    if (touches) add_contacts(step, b, gain);
    in.run.gain = gain.data();
    in.by_gain = by_gain_.data() + 3 * begin;
  }
  in.by_undisplaced = adj_undisplaced_.empty() ? nullptr : adj_undisplaced_.data() + 12 * begin;
  const bool uniform = uniform_ != StressKind::kGiven && !in.run.viscous;
  kernels_.elastic_impulses[static_cast<int>(uniform ? uniform_ : StressKind::kGiven)](
      in, adj->lane, record, patch_[patch].lane, old_patch_[patch].lane);
  if (!loaded) return;
  reverse_body_loads(step, b, now.data(), in.by_gain);
  followed_[b] = 1;
}

/// Places and velocities of the particles of a block at the start of the step.
template <class T>
void StepAdjoint<T>::follow_block(const TapeStep<T>& step, int b) {
  std::vector<TapeParticle<T>> now(step.begin[b + 1] - step.begin[b]);
  forward_.follow_nodes(elastic_run(step, b).run, Follow::kBoth, now.data());
  for (size_t i = 0; i < now.size(); ++i) {
    where_[step.begin[b] + i] = Eigen::Map<const Vec3<T>>(now[i].x);
    moving_[step.begin[b] + i] = Eigen::Map<const Vec3<T>>(now[i].v);
  }
}

/// Adds what contact gives to the particles of a block to `gain` [count, 3].
template <class T>
void StepAdjoint<T>::add_contacts(const TapeStep<T>& step, int b, std::vector<T>& gain) const {
  const T friction = static_cast<T>(step.loads.object_friction);
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s) {
    const Vec3<T> given = contact_gain<T>(solver_, contacts_, s, where_, moving_, step.dt, friction);
    for (int a = 0; a < 3; ++a) gain[3 * (s - step.begin[b]) + a] += given[a];
  }
}

/// `Mpm::add_contacts` backwards, for what the particles of a block bring to their contacts, as the first or as the
/// second of a pair.
template <class T>
void StepAdjoint<T>::reverse_contacts(const TapeStep<T>& step, int b) {
  const T dt = step.dt, friction = static_cast<T>(step.loads.object_friction);
  const auto by_gain = [&](int s) { return Eigen::Map<const Vec3<T>>(by_gain_.data() + 3 * static_cast<size_t>(s)); };
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s) {
    if (contacts_.near(s).empty()) continue;
    AdjointRecord<T>& r = record_[s];
    ParticleContactGradient<T> by;
    for (const int other : contacts_.near(s)) {
      const ContactPair<T> pair = contact_pair<T>(solver_, s, other, where_, moving_);
      const Vec3<T> adj_J = by_gain(s) / pair.mass[0] - by_gain(other) / pair.mass[1];
      contact_impulse_adjoint(pair, dt, friction, adj_J, by);
      by.mass -= by_gain(s).dot(contact_impulse(pair, dt, friction)) / (pair.mass[0] * pair.mass[0]);
    }
    for (int a = 0; a < 3; ++a) {
      r.x[a] += by.x[a];
      r.v[a] += by.v[a];
    }
    const T by_modulus = by.stiffness * r.volume * solver_.inverse_dx * solver_.inverse_dx;
    r.by_mass += by.mass;
    r.by_mu += 2 * by_modulus;
    r.by_lambda += by_modulus;
    followed_[b] = 1;
  }
}

/// `Mpm::load_nodes` backwards.
template <class T>
void StepAdjoint<T>::reverse_load_nodes(const TapeStep<T>& first, const BasicSimulationState<T>& state,
                                        StateGradient<T>& gradient) {
  for (int b = 0; b < first.grid->particle_blocks(); ++b) reverse_follow(first, b);
  for (int n = 0; n < first.grid->node_blocks(); ++n) sum_node_gradient(*first.grid, n);
  if (!adj_undisplaced_.empty()) reverse_undisplaced();
  gradient.node_displacement.clear();
  gradient.node_velocity.clear();
  if (state.node_velocity.empty()) {
    reverse_projections(state);
  } else {
    gradient.node_displacement = adj_displacement_;
    gradient.node_velocity = adj_velocity_;
  }
}

/// `Mpm::find_undisplaced` backwards.
template <class T>
void StepAdjoint<T>::reverse_undisplaced() {
  const T scale = 4 * solver_.inverse_dx * solver_.inverse_dx;
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  const auto by_x = [&](size_t s) { return Eigen::Map<const Vec3<T>>(adj_undisplaced_.data() + 12 * s); };
  const auto by_F = [&](size_t s) { return Eigen::Map<const RowMajor>(adj_undisplaced_.data() + 12 * s + 3); };
  for (size_t s = 0; s < record_.size(); ++s) {
    for (int a = 0; a < 3; ++a) record_[s].x[a] += by_x(s)[a];
    for (int k = 0; k < 9; ++k) record_[s].F[k] += by_F(s).data()[k];
  }
  const std::vector<Node<T>> sums = sum_over_particles(solver_, [&](int s, T w, const Vec3<T>& d, T* lane) {
    const Vec3<T> at_node = w * (by_x(s) + scale * by_F(s) * d);
    for (int a = 0; a < 3; ++a) lane[a] += at_node[a];
  });
  for (size_t i = 0; i < sums.size(); ++i) adj_displacement_[i] -= three(sums[i]);
}

/// `project_displacements` and `project_velocities` backwards.
template <class T>
void StepAdjoint<T>::reverse_projections(const BasicSimulationState<T>& state) {
  const auto reverse = [&](const std::vector<Node<T>>& projected, const std::vector<Vec3<T>>& adj, auto&& add) {
    // By the sums of mass times value, and in `by_mass` by the mass.
    std::vector<Node<T>> by_sum(adj.size(), Node<T>{}), by_mass = by_sum;
    for (size_t i = 0; i < adj.size(); ++i) {
      const T mass = projected[i].lane[3];
      if (!(mass > T(0))) continue;
      for (int a = 0; a < 3; ++a) by_sum[i].lane[a] = adj[i][a] / mass;
      by_mass[i].lane[0] = -three(by_sum[i]).dot(three(projected[i]));
    }
    for_particles(solver_, by_mass, [&](int s, const AtParticle<T>& by) { record_[s].by_mass += by.value[0]; });
    for_particles(solver_, by_sum, [&](int s, const AtParticle<T>& by) { add(record_[s], by); });
  };
  const auto add_to = [](const AdjointRecord<T>& r, const AtParticle<T>& by, T* by_value, T* by_gradient) {
    for (int a = 0; a < 3; ++a) {
      by_value[a] += r.mass * by.value[a];
      for (int c = 0; c < 3; ++c) by_gradient[3 * a + c] += r.mass * by.moment(a, c);
    }
  };
  reverse(project_displacements(solver_, state), adj_displacement_, [&](AdjointRecord<T>& r, const AtParticle<T>& by) {
    const int i = r.index;
    r.by_mass += by.value.dot(state.x[i] - solver_.reference[i]) +
                 by.moment.cwiseProduct(state.F[i] - Mat3<T>::Identity()).sum();
    add_to(r, by, r.x, r.F);
  });
  reverse(project_velocities(solver_, state), adj_velocity_, [&](AdjointRecord<T>& r, const AtParticle<T>& by) {
    r.by_mass += by.value.dot(state.v[r.index]) + by.moment.cwiseProduct(state.C[r.index]).sum();
    add_to(r, by, r.v, r.C);
  });
}

/// What the nodes' own constants say of those of the particles: their stabilization is the sum over w times that of the
/// particles, which is so much of mu, and their damping rate the mean of the particles', by mass.
template <class T>
void StepAdjoint<T>::add_node_constants(ParticleGradient<T>& by) const {
  std::vector<Node<T>> by_node(adj_stabilization_.size(), Node<T>{});
  for (size_t i = 0; i < by_node.size(); ++i) {
    by_node[i].lane[0] = adj_stabilization_[i];
    const T mass = solver_.node_velocity[i].lane[3];
    if (adj_damping_.empty() || !(mass > T(0))) continue;
    by_node[i].lane[1] = adj_damping_[i] / mass;
    by_node[i].lane[2] = -by_node[i].lane[1] * solver_.node_damping[i];
  }
  for_particles(solver_, by_node, [&](int s, const AtParticle<T>& at) {
    const RestParticle<T>& p = solver_.rest[s];
    const int i = solver_.record[s].index;
    by.mu[i] += at.value[0] * p.stabilization / p.mu;
    by.damping_rate[i] += at.value[1] * p.mass;
    by.mass[i] += at.value[1] * solver_.record[s].damping_rate + at.value[2];
  });
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
