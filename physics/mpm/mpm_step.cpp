#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/object_contact.h"
#include "physics/mpm/team.h"

namespace pliant {

template <class T>
bool Mpm<T>::advance(int count, T dt, StepLoads<T>& loads, const std::function<void(int)>& prepare,
                     const std::function<bool()>& check, StepTape<T>* tape) {
  CHECK_MSG(!tape || !sleeping(), "steps in which something sleeps cannot be recorded");
  // Records are brought into the order of the blocks again when one in so many has changed its block.
  constexpr int kMovesPerReorder = 64;
  constexpr int kParticlesPerThread = 1000;  // below this a thread costs more than it brings
  const int useful = static_cast<int>(std::min<size_t>(data_.record.size() / kParticlesPerThread, 1024));
  const int threads = std::clamp(omp_get_max_threads(), 1, std::max(1, useful));
  std::exception_ptr error;
  Queue reorder, search, meet, follow, scatter, update, contact, conditions, gather;
  if (tape) {
    tape->low = data_.low;
    tape->high = data_.high;
  }
  bool going = true, good = true, reordering = false, searching = false;
  const int chunks = static_cast<int>((data_.record.size() + kReorderChunk - 1) / kReorderChunk);
  // What one thread does between steps.
  const auto between = [&](int k) {
    try {
      if (k > 0) {
        collect_reports();
        contacts_.travel(max_speed_, dt, data_.dx);
        good = finite_ && check();
      }
      going = good && k < count;
      if (going) {
        prepare(k);
        clear_impulses(loads);
        find_kept(dt);
      }
      if (going && sleeping()) wake_on_change(loads);
      reordering = going && moves_since_reorder_ * kMovesPerReorder > static_cast<int64_t>(data_.record.size());
      searching = going && options_.lagrangian && options_.contact && contacts_.stale();
      if (reordering) spare_record_.resize(data_.record.size());
      if (going && tape) {
        tape->begin_step(dt, loads, data_.grid, data_.side.size(), flip(dt), options_.lagrangian);
      }
    } catch (...) {
      error = std::current_exception();
      going = false;
    }
    scatter.reset();
    update.reset();
    contact.reset();
    conditions.reset();
    gather.reset();
    reorder.reset();
    search.reset();
    meet.reset();
    follow.reset();
  };
  std::unique_ptr<Barrier> barrier;
#pragma omp parallel num_threads(threads)
  {
#pragma omp single
    barrier = std::make_unique<Barrier>(omp_get_num_threads());
    for (int k = 0;; ++k) {
      if (omp_get_thread_num() == 0) between(k);
      barrier->wait();
      if (!going) break;
      if (reordering) {
        for (int c; (c = reorder.take()) < chunks;) reorder_chunk(c);
        barrier->wait();
        if (omp_get_thread_num() == 0) {
          data_.record.swap(spare_record_);
          moves_since_reorder_ = 0;
        }
        barrier->wait();
      }
      if (searching) {
        for (int b; (b = search.take()) < data_.grid.particle_blocks();) follow_block(b);
        barrier->wait();
        if (omp_get_thread_num() == 0) contacts_.sort(data_, where_);
        barrier->wait();
        for (int c; (c = meet.take()) < contacts_.chunks();) contacts_.search(data_, c);
        barrier->wait();
        if (omp_get_thread_num() == 0) contacts_.finish(data_);
        barrier->wait();
      }
      if (touching() && !searching) {
        for (int b; (b = follow.take()) < data_.grid.particle_blocks();)
          if (contacts_.block_touches()[b]) follow_block(b);
        barrier->wait();
      }
      if (tape && omp_get_thread_num() == 0) tape->last().touching = touching();
      for (int b; (b = scatter.take()) < data_.grid.particle_blocks();) {
        if (tape) record_block(b, tape->last());
        scatter_block(b, dt, loads);
      }
      barrier->wait();
      const bool meeting = meeting_on_nodes();
      for (int n; (n = update.take()) < data_.grid.node_blocks();) {
        sum_node_block(n);
        if (tape) record_node_block(n, tape->last());
        update_node_block(n, dt, loads);
        if (!meeting) condition_node_block(n, dt, loads);
      }
      barrier->wait();
      if (meeting) {
        for (int n; (n = contact.take()) < data_.grid.node_blocks();)
          apply_object_contact(loads, data_.grid, data_.dx, data_.node, n);
        barrier->wait();
        for (int n; (n = conditions.take()) < data_.grid.node_blocks();) condition_node_block(n, dt, loads);
        barrier->wait();
      }
      if (options_.lagrangian) continue;  // particles follow the nodes
      for (int b; (b = gather.take()) < data_.grid.particle_blocks();) gather_block(b, dt, loads);
      barrier->wait();
    }
  }
  if (error) std::rethrow_exception(error);
  return good;
}

template <class T>
void Mpm<T>::record_block(int b, TapeStep<T>& step) const {
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s) {
    const ParticleRecord<T>& r = data_.record[data_.grid.order()[s]];
    step.index[s] = r.index;
    if (options_.lagrangian) continue;
    TapeParticle<T>& to = step.particle[s];
    std::copy_n(r.x, 3, to.x);
    std::copy_n(r.F, 9, to.F);
    std::copy_n(r.v, 3, to.v);
    std::copy_n(r.C, 9, to.C);
    if (r.side < 0) continue;
    step.memory[r.side] = data_.side[r.side].memory;
    std::copy_n(data_.given_stress.data() + 6 * r.side, 6, step.given_stress.data() + 6 * r.side);
  }
}

template <class T>
void Mpm<T>::record_node_block(int n, TapeStep<T>& step) const {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  std::copy_n(data_.node.data() + first, BlockGrid::kNodes, step.node.data() + first);
  if (step.flip > T(0)) std::copy_n(data_.old_node.data() + first, BlockGrid::kNodes, step.old_node.data() + first);
  if (!options_.lagrangian) return;
  std::copy_n(data_.node_velocity.data() + first, BlockGrid::kNodes, step.node_velocity.data() + first);
  std::copy_n(data_.node_displacement.data() + first, BlockGrid::kNodes, step.node_displacement.data() + first);
}

template <class T>
typename Mpm<T>::Snapshot Mpm<T>::save() const {
  Snapshot snapshot;
  snapshot.record_ = data_.record;
  snapshot.slot_ = data_.slot;
  snapshot.grid_ = data_.grid;
  snapshot.node_displacement_ = data_.node_displacement;
  snapshot.node_displacement_rest_ = data_.node_displacement_rest;
  snapshot.node_velocity_ = data_.node_velocity;
  snapshot.side_ = data_.side;
  snapshot.given_stress_ = data_.given_stress;
  snapshot.rest_of_block_ = rest_of_block_;
  snapshot.moves_since_reorder_ = moves_since_reorder_;
  return snapshot;
}

template <class T>
void Mpm<T>::restore(const Snapshot& snapshot) {
  CHECK(snapshot.record_.size() == rest_.size());
  data_.record = snapshot.record_;
  data_.slot = snapshot.slot_;
  data_.grid = snapshot.grid_;
  data_.node_displacement = snapshot.node_displacement_;
  data_.node_displacement_rest = snapshot.node_displacement_rest_;
  data_.node_velocity = snapshot.node_velocity_;
  data_.side = snapshot.side_;
  data_.given_stress = snapshot.given_stress_;
  rest_of_block_ = snapshot.rest_of_block_;
  moves_since_reorder_ = snapshot.moves_since_reorder_;
  contacts_.clear();
  fit_blocks();
}

template <class T>
void Mpm<T>::particles_to_grid(T dt, const StepLoads<T>& loads) {
  clear_impulses(loads);
  find_kept(dt);
  const int blocks = data_.grid.particle_blocks();
  if (options_.lagrangian && options_.contact) {
    for (int b = 0; b < blocks; ++b) follow_block(b);
    contacts_.build(data_, where_);
  }
  for (int b = 0; b < blocks; ++b) scatter_block(b, dt, loads);
  for (int n = 0; n < data_.grid.node_blocks(); ++n) sum_node_block(n);
}

template <class T>
void Mpm<T>::update_grid(T dt, const StepLoads<T>& loads) {
  const int blocks = data_.grid.node_blocks();
  for (int n = 0; n < blocks; ++n) update_node_block(n, dt, loads);
  if (meeting_on_nodes())
    for (int n = 0; n < blocks; ++n) apply_object_contact(loads, data_.grid, data_.dx, data_.node, n);
  for (int n = 0; n < blocks; ++n) condition_node_block(n, dt, loads);
}

template <class T>
void Mpm<T>::grid_to_particles(T dt) {
  if (!options_.lagrangian)
    for (int b = 0; b < data_.grid.particle_blocks(); ++b) gather_block(b, dt, {});
  collect_reports();
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
