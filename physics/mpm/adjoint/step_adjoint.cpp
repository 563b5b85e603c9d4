#include "physics/mpm/adjoint/step_adjoint.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/mpm/object_contact.h"
#include "physics/mpm/rest_stencil.h"
#include "physics/mpm/team.h"

namespace pliant {
namespace {

/// Largest speed of the nodes from their mean velocity, each times the share with which it is seen (NodeFrame).
template <class T>
double max_speed(const std::vector<Node<T>>& velocity, const std::vector<T>& seen) {
  Vec3d momentum = Vec3d::Zero();
  double mass = 0;
  for (const Node<T>& node : velocity) {
    momentum += node.lane[3] * three(node).template cast<double>();
    mass += node.lane[3];
  }
  const Vec3<T> drift = (momentum / mass).template cast<T>();
  T square = 0;
  for (size_t i = 0; i < velocity.size(); ++i)
    if (velocity[i].lane[3] > T(0)) square = std::max(square, (seen[i] * (three(velocity[i]) - drift)).squaredNorm());
  return std::sqrt(static_cast<double>(square));
}

}  // namespace

template <class T>
StepAdjoint<T>::StepAdjoint(const BasicParticles<T>& particles, const MpmData<T>& solver)
    : particles_(particles),
      solver_(solver),
      forward_(mpm_kernels<T>(best_instruction_set())),
      kernels_(adjoint_kernels<T>(best_instruction_set())),
      record_(particles.size()),
      slot_(particles.size()) {
  for (size_t i = 0; i < record_.size(); ++i) {
    record_[i] = {};
    record_[i].index = slot_[i] = static_cast<int>(i);
  }
}

template <class T>
void StepAdjoint<T>::set_constants(AdjointRecord<T>& r, const ParticleRecord<T>& of) const {
  r.mass = of.mass;
  r.volume = of.volume;
  r.mu = of.mu;
  r.lambda = of.lambda;
  r.shear_viscosity = of.shear_viscosity;
  r.bulk_viscosity = of.bulk_viscosity;
  r.damping_rate = of.damping_rate;
  r.stress_kind = of.stress_kind;
  r.bits = of.bits;
  r.material = of.material;
  r.side = of.side;
  const Material& material = particles_.materials[of.material];
  r.viscosity_time = material.law == Law::kFluid ? T(0) : static_cast<T>(material.viscosity_time);
}

template <class T>
void StepAdjoint<T>::load(const StateGradient<T>& gradient, const BasicSimulationState<T>& state,
                          const StepTape<T>& tape) {
  CHECK(tape.size() > 0 && gradient.x.size() == record_.size() && state.size() == record_.size());
  // Records lie in memory as the blocks are walked.
  const TapeStep<T>& last = tape[tape.size() - 1];
  std::vector<AdjointRecord<T>> sorted(record_.size());
  for (size_t s = 0; s < record_.size(); ++s) sorted[s] = record_[slot_[last.index[s]]];
  record_ = std::move(sorted);
  memory_.assign(solver_.side.size(), {});
  by_branch_.resize(solver_.side.size());
  load_node_gradient(gradient, last);
  viscous_ = false;
  uniform_ = static_cast<StressKind>(static_cast<int>(solver_.record[0].stress_kind));
  if (uniform_ == StressKind::kHencky) uniform_ = StressKind::kGiven;
  for (size_t s = 0; s < record_.size(); ++s) {
    AdjointRecord<T>& r = record_[s];
    const int i = r.index;
    slot_[i] = static_cast<int>(s);
    set_constants(r, solver_.record[solver_.slot[i]]);
    viscous_ |= r.shear_viscosity != T(0) || r.bulk_viscosity != T(0);
    if (viscous_ || (r.damping_rate != T(0) && !last.lagrangian()) ||
        r.stress_kind != static_cast<T>(static_cast<int>(uniform_)))
      uniform_ = StressKind::kGiven;
    int put_back = 0;
    for (int a = 0; a < 3; ++a) {
      r.x[a] = gradient.x[i][a];
      r.v[a] = gradient.v[i][a];
      r.v_after[a] = state.v[i][a];
      put_back |= (state.x[i][a] == tape.low[a] || state.x[i][a] == tape.high[a]) << a;
      for (int c = 0; c < 3; ++c) {
        r.C[3 * a + c] = gradient.C[i](a, c);
        r.F[3 * a + c] = gradient.F[i](a, c);
        r.C_after[3 * a + c] = state.C[i](a, c);
      }
    }
    r.put_back = static_cast<T>(put_back);
    if (gradient.memory.empty()) continue;
    if (r.side >= 0) memory_[r.side] = gradient.memory[i];
    // Without a memory the elastic part is the whole.
    if (r.side >= 0 && has_memory(particles_.materials[r.material].law)) continue;
    for (int k = 0; k < 9; ++k) r.F[k] += gradient.memory[i].F_total(k / 3, k % 3);
  }
}

template <class T>
void StepAdjoint<T>::store(const BasicSimulationState<T>& state, const StepTape<T>& tape, StateGradient<T>& gradient) {
  if (tape[0].lagrangian()) reverse_load_nodes(tape[0], state, gradient);
  gradient.memory.assign(particles_.has_memory() ? record_.size() : 0, {});
  for (const AdjointRecord<T>& r : record_) {
    if (r.side >= 0 && has_memory(particles_.materials[r.material].law)) gradient.memory[r.index] = memory_[r.side];
    for (int a = 0; a < 3; ++a) {
      gradient.x[r.index][a] = r.x[a];
      gradient.v[r.index][a] = r.v[a];
      for (int c = 0; c < 3; ++c) {
        gradient.C[r.index](a, c) = r.C[3 * a + c];
        gradient.F[r.index](a, c) = r.F[3 * a + c];
      }
    }
  }
}

template <class T>
ParticleGradient<T> StepAdjoint<T>::particle_gradient() const {
  const size_t n = record_.size();
  ParticleGradient<T> result;
  for (std::vector<T>* field : {&result.mass, &result.mu, &result.lambda, &result.viscosity_time, &result.damping_rate})
    field->resize(n);
  for (const AdjointRecord<T>& r : record_) {
    result.mass[r.index] = r.by_mass;
    result.mu[r.index] = r.by_mu;
    result.lambda[r.index] = r.by_lambda;
    result.viscosity_time[r.index] = r.by_viscosity_time;
    result.damping_rate[r.index] = r.by_damping_rate;
  }
  if (std::ranges::any_of(particles_.materials, [](const Material& m) { return m.law == Law::kViscoelastic; })) {
    result.branch.resize(n);
    for (const AdjointRecord<T>& r : record_)
      if (r.side >= 0) result.branch[r.index] = by_branch_[r.side];
  }
  if (!adj_stabilization_.empty()) add_node_constants(result);
  return result;
}

template <class T>
size_t StepAdjoint<T>::bytes() const {
  return record_.capacity() * (sizeof(AdjointRecord<T>) + sizeof(int)) +
         (velocity_.capacity() + updated_.capacity() + before_contact_.capacity() + by_contact_mass_.capacity() +
          adj_node_.capacity() + patch_.capacity() + old_patch_.capacity() + adj_old_node_.capacity()) *
             sizeof(Node<T>) +
         3 * adj_velocity_.capacity() * sizeof(Vec3<T>) + adj_stabilization_.capacity() * sizeof(T);
}

template <class T>
void StepAdjoint<T>::reverse(const StepTape<T>& tape, const std::function<void(int, const StepLoadsGradient&)>& loads) {
  constexpr int kParticlesPerThread = 1000;  // below this a thread costs more than it brings
  const int useful = static_cast<int>(std::min<size_t>(record_.size() / kParticlesPerThread, 1024));
  const int threads = std::clamp(omp_get_max_threads(), 1, std::max(1, useful));
  std::exception_ptr error;
  Queue search, meet, follow, touch, forward, contact, conditions, gather, reverse_nodes, separate, update, scatter;
  bool going = true, searching = false;
  // What one thread does between steps.
  const auto between = [&](int k) {
    try {
      if (k + 1 < tape.size()) loads(k + 1, sum_loads(tape[k + 1]));
      going = k >= 0;
      if (going) begin_step(tape, tape[k]);
      if (going && k + 1 < tape.size() && tape[k].touching)
        contacts_.travel(max_speed(tape[k + 1].node_velocity, solver_.node_seen), tape[k].dt, solver_.dx);
      else
        contacts_.clear();
      searching = contacts_.stale();
    } catch (...) {
      error = std::current_exception();
      going = false;
    }
    for (Queue* queue : {&search, &meet, &follow, &touch, &forward, &contact, &conditions, &gather, &reverse_nodes,
                         &separate, &update, &scatter})
      queue->reset();
  };
  std::unique_ptr<Barrier> barrier;
#pragma omp parallel num_threads(threads)
  {
#pragma omp single
    barrier = std::make_unique<Barrier>(omp_get_num_threads());
    for (int k = tape.size() - 1;; --k) {
      if (omp_get_thread_num() == 0) between(k);
      barrier->wait();
      if (!going) break;
      const TapeStep<T>& step = tape[k];
      const int blocks = step.grid->particle_blocks(), node_blocks = step.grid->node_blocks();
      const bool several = step.grid->has_siblings() && !step.lagrangian();
      for (int n; (n = forward.take()) < node_blocks;) {
        find_velocities(step, n);
        if (!several) find_conditioned_velocities(step, n);
      }
      barrier->wait();
      if (several) {
        for (int n; (n = contact.take()) < node_blocks;)
          apply_object_contact(step.loads, *step.grid, solver_.dx, updated_, n);
        barrier->wait();
        for (int n; (n = conditions.take()) < node_blocks;) find_conditioned_velocities(step, n);
        barrier->wait();
      }
      for (int b; (b = gather.take()) < blocks;) reverse_gather(step, b);
      barrier->wait();
      for (int n; (n = reverse_nodes.take()) < node_blocks;) {
        reverse_conditions(step, n);
        if (!several) reverse_update(step, n);
      }
      barrier->wait();
      if (several) {
        for (int n; (n = separate.take()) < node_blocks;) reverse_contact(step, n);
        barrier->wait();
        for (int n; (n = update.take()) < node_blocks;) reverse_update(step, n);
        barrier->wait();
      }
      if (step.touching) {
        if (searching) {
          for (int b; (b = search.take()) < blocks;) follow_block(step, b);
          barrier->wait();
          if (omp_get_thread_num() == 0) contacts_.sort(solver_, where_);
          barrier->wait();
          for (int c; (c = meet.take()) < contacts_.chunks();) contacts_.search(solver_, c);
          barrier->wait();
          if (omp_get_thread_num() == 0) contacts_.finish(solver_);
          barrier->wait();
        } else {
          for (int b; (b = follow.take()) < blocks;)
            if (contacts_.block_touches()[b]) follow_block(step, b);
          barrier->wait();
        }
      }
      for (int b; (b = scatter.take()) < blocks;) reverse_scatter(step, b);
      barrier->wait();
      if (step.touching) {
        for (int b; (b = touch.take()) < blocks;)
          if (contacts_.block_touches()[b]) reverse_contacts(step, b);
        barrier->wait();
      }
    }
  }
  if (error) std::rethrow_exception(error);
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
