#include <algorithm>
#include <cmath>

#include "physics/laws/law.h"
#include "physics/mpm/adjoint/node_update_adjoint.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/node_sums.h"
#include "physics/mpm/object_contact.h"

namespace pliant {
namespace {

constexpr int kPatch = BlockGrid::kPatch, kSide = BlockGrid::kSide;

template <class T>
using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;

template <class T>
void six_of(const Mat3<T>& m, T* six) {
  six[0] = m(0, 0);
  six[1] = m(1, 1);
  six[2] = m(2, 2);
  six[3] = m(1, 2);
  six[4] = m(0, 2);
  six[5] = m(0, 1);
}
template <class T>
Mat3<T> symmetric(const T* six) {
  Mat3<T> m;
  m << six[0], six[5], six[4], six[5], six[1], six[3], six[4], six[3], six[2];
  return m;
}

template <class T>
void exact_stress(StressKind kind, const T* F, T mu, T lambda, T* tau) {
  six_of<T>(kirchhoff_stress<T>(LawPoint<T>{&plain_material(kind), mu, lambda}, Eigen::Map<const RowMajor<T>>(F),
                                LawMemory<T>{}),
            tau);
}

template <class T>
void exact_adjoint(StressKind kind, const T* F, T mu, T lambda, const T* S, T* by_F, T* by_lame) {
  const LawGradient<T> g = kirchhoff_stress_adjoint<T>(LawPoint<T>{&plain_material(kind), mu, lambda},
                                                       Eigen::Map<const RowMajor<T>>(F), LawMemory<T>{}, symmetric(S));
  Eigen::Map<RowMajor<T>>{by_F} = g.F;
  by_lame[0] = g.mu;
  by_lame[1] = g.lambda;
}

/// The values of block n, of those of all nodes.
template <class Values>
auto* block_of(Values& nodes, int n) {
  return nodes.data() + static_cast<size_t>(n) * BlockGrid::kNodes;
}

}  // namespace

template <class T>
void StepAdjoint<T>::begin_step(const StepTape<T>& tape, const TapeStep<T>& step) {
  run_ = {};
  run_.dt = step.dt;
  run_.flip = step.flip;
  run_.viscosity_time = step.loads.viscosity_time;
  run_.dx = solver_.dx;
  run_.inverse_dx = solver_.inverse_dx;
  for (int a = 0; a < 3; ++a) {
    run_.origin[a] = solver_.origin[a];
    run_.low[a] = tape.low[a];
    run_.high[a] = tape.high[a];
  }
  run_.slot = slot_.data();
  run_.record = record_.data();
  run_.exact_stress = exact_stress<T>;
  run_.exact_adjoint = exact_adjoint<T>;
  const BlockGrid& grid = *step.grid;
  kept_.resize(step.lagrangian() ? solver_.node_damping.size() : 0);
  for (size_t i = 0; i < kept_.size(); ++i) kept_[i] = std::exp(-step.dt * solver_.node_damping[i]);
  velocity_.resize(step.node.size());
  updated_.resize(step.node.size());
  adj_node_.resize(step.node.size());
  const bool several = grid.has_siblings() && !step.lagrangian();
  by_density_.assign(several ? grid.node_blocks() : 0, 0.0);
  if (several) {
    before_contact_.resize(step.node.size());
    by_contact_mass_.assign(step.node.size(), Node<T>{});
  }
  patch_.resize(static_cast<size_t>(grid.particle_blocks()) * BlockGrid::kPatchNodes);
  block_sums_.assign(step.loads.body.size() * grid.particle_blocks(), {});
  node_sums_.resize(grid.node_blocks());
  if (step.flip > T(0)) {
    adj_old_node_.resize(step.node.size());
    old_patch_.resize(patch_.size());
  }
}

template <class T>
AdjointRun<T> StepAdjoint<T>::run_of(const TapeStep<T>& step, int b) const {
  AdjointRun<T> run = run_;
  run.particle = step.particle.data() + step.begin[b];
  run.index = step.index.data() + step.begin[b];
  run.count = step.begin[b + 1] - step.begin[b];
  return run;
}

template <class T>
NodeBlock<T> StepAdjoint<T>::node_block(const TapeStep<T>& step, std::vector<Node<T>>& nodes, int n) const {
  const BlockGrid::Coordinates& block = step.grid->node_block(n);
  const double dx = solver_.dx;
  return {block_of(nodes, n),
          solver_.origin.template cast<double>() + dx * kSide * Vec3d(block.x, block.y, block.z),
          dx,
          block.object,
          step.lagrangian() ? block_of(step.node_displacement, n) : nullptr,
          step.lagrangian() ? block_of(solver_.node_filled, n) : nullptr};
}

template <class T>
void StepAdjoint<T>::find_velocities(const TapeStep<T>& step, int n) {
  Node<T>* node = block_of(updated_, n);
  const Vec3<T> fall = step.dt * step.loads.gravity;
  if (step.lagrangian()) {
    std::copy_n(block_of(step.node_velocity, n), BlockGrid::kNodes, node);
    forward_.push_nodes(solver_.active[n], block_of(step.node, n)->lane, kept_.empty() ? nullptr : block_of(kept_, n),
                        fall.data(), step.loads.velocity_scale, node->lane);
    return;
  }
  std::copy_n(block_of(step.node, n), BlockGrid::kNodes, node);
  forward_.update_nodes(node->lane, fall.data(), step.loads.velocity_scale);
  if (step.grid->has_siblings()) std::copy_n(node, BlockGrid::kNodes, block_of(before_contact_, n));
}

template <class T>
void StepAdjoint<T>::find_conditioned_velocities(const TapeStep<T>& step, int n) {
  const NodeBlock<T> block = node_block(step, velocity_, n);
  std::copy_n(block_of(updated_, n), BlockGrid::kNodes, block.node);
  apply_node_conditions(step.loads, block);
}

/// The affine velocity that moved F is not that of the particle when it is damped afterwards or blended with the old
/// one, so it is found again from the nodes.
template <class T>
void StepAdjoint<T>::reverse_affine_damping(const TapeStep<T>& step, int b, const Node<T>* velocity) {
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s) {
    AdjointRecord<T>& r = record_[slot_[step.index[s]]];
    const Mat3<T> by = Eigen::Map<const RowMajor<T>>(r.C);
    Eigen::Map<RowMajor<T>>(r.C) =
        T(0.5) * (step.loads.strain_rate_kept * (by + by.transpose()) + step.loads.spin_kept * (by - by.transpose()));
    const T* x = step.particle[s].x;
    const auto along = [&](int a) { return Spline<T>((x[a] - run_.origin[a]) * run_.inverse_dx); };
    const Spline<T> sx = along(0), sy = along(1), sz = along(2);
    Mat3<T> C = Mat3<T>::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
          const T* v = velocity[(((sx.base & 3) + i) * kPatch + (sy.base & 3) + j) * kPatch + (sz.base & 3) + k].lane;
          C += (4 * run_.inverse_dx * sx.weight[i] * sy.weight[j] * sz.weight[k]) * Vec3<T>(v[0], v[1], v[2]) *
               Vec3<T>(T(i) - sx.offset, T(j) - sy.offset, T(k) - sz.offset).transpose();
        }
    Eigen::Map<RowMajor<T>>(r.C_after) = C;
  }
}

/// F' and the memory come from (I + dt C) times what was, C that of the grid, through the return map; see
/// `Mpm::apply_laws`.
template <class T>
void StepAdjoint<T>::reverse_return_maps(const TapeStep<T>& step, int b, T* by_grid_C) {
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s, by_grid_C += 9) {
    AdjointRecord<T>& r = record_[slot_[step.index[s]]];
    if (r.side < 0) continue;
    const LawPoint<T> point{&particles_.materials[r.material], r.mu, r.lambda};
    if (!has_memory(point.material->law)) continue;
    const LawMemory<T>& before = step.memory[r.side];
    const Mat3<T> advance = Mat3<T>::Identity() + step.dt * Eigen::Map<const RowMajor<T>>(r.C_after);
    const Mat3<T> trial_F = advance * Eigen::Map<const RowMajor<T>>(step.particle[s].F);
    LawMemory<T> trial = before;
    trial.F_viscous = advance * before.F_viscous;
    MemoryGradient<T>& memory = memory_[r.side];
    LawGradient<T> by;
    by.F = Eigen::Map<const RowMajor<T>>(r.F);
    by.F_viscous = memory.F_viscous;
    by.history = memory.history;
    by = return_map_adjoint(point, step.dt, trial_F, trial, by);
    Eigen::Map<RowMajor<T>>(r.F) = by.F;
    r.by_mu += by.mu;
    r.by_lambda += by.lambda;
    by_branch_[r.side] += by.branch;
    Eigen::Map<RowMajor<T>>{by_grid_C} =
        step.dt * (by.F_viscous * before.F_viscous.transpose() + memory.F_total * before.F_total.transpose());
    memory.F_viscous = advance.transpose() * by.F_viscous;
    memory.F_total = advance.transpose() * memory.F_total.eval();
    memory.history = by.history;
  }
}

template <class T>
void StepAdjoint<T>::reverse_given_stress(const TapeStep<T>& step, int b, const T* by_stress) {
  for (int s = step.begin[b]; s < step.begin[b + 1]; ++s, by_stress += 6) {
    AdjointRecord<T>& r = record_[slot_[step.index[s]]];
    if (r.side < 0) continue;
    const LawPoint<T> point{&particles_.materials[r.material], r.mu, r.lambda};
    const LawGradient<T> by = kirchhoff_stress_adjoint<T>(point, Eigen::Map<const RowMajor<T>>(step.particle[s].F),
                                                          step.memory[r.side], symmetric(by_stress));
    Eigen::Map<RowMajor<T>>(r.F) += by.F;
    r.by_mu += by.mu;
    r.by_lambda += by.lambda;
    by_branch_[r.side] += by.branch;
    memory_[r.side].F_viscous += by.F_viscous;
    memory_[r.side].history += by.history;
  }
}

template <class T>
void StepAdjoint<T>::reverse_gather(const TapeStep<T>& step, int b) {
  if (step.lagrangian()) return reverse_follow(step, b);
  alignas(64) Node<T> velocity[2][BlockGrid::kPatchNodes];
  const auto cleared = [&](std::vector<Node<T>>& patches) {
    Node<T>* patch = patches.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
    return std::fill_n(patch, BlockGrid::kPatchNodes, Node<T>{}), patch->lane;
  };
  collect_patch(*step.grid, b, velocity_, velocity[0]);
  if (step.flip > T(0) || step.loads.strain_rate_kept != T(1) || step.loads.spin_kept != T(1))
    reverse_affine_damping(step, b, velocity[0]);
  AdjointRun<T> run = run_of(step, b);
  std::vector<T> by_grid_C(particles_.has_memory() ? 9 * static_cast<size_t>(run.count) : 0);
  if (!by_grid_C.empty()) {
    reverse_return_maps(step, b, by_grid_C.data());
    run.by_grid_C = by_grid_C.data();
  }
  T* old_patch = nullptr;
  if (step.flip > T(0)) {
    collect_patch(*step.grid, b, step.old_node, velocity[1]);
    old_patch = cleared(old_patch_);
  }
  kernels_.gather(run, velocity[0]->lane, cleared(patch_), velocity[1]->lane, old_patch);
}

template <class T>
void StepAdjoint<T>::reverse_conditions(const TapeStep<T>& step, int n) {
  const NodeBlock<T> block = node_block(step, adj_node_, n);
  if (step.lagrangian())
    reverse_displacement(step, n);
  else
    sum_patches(forward_, *step.grid, n, patch_, adj_node_);
  if (step.flip > T(0)) {
    sum_patches(forward_, *step.grid, n, old_patch_, adj_old_node_);
    reverse_node_average(block_of(step.old_node, n), block_of(adj_old_node_, n));
  }
  if (!step.loads.colliders.empty() || !step.loads.pins.empty())
    apply_node_conditions_adjoint(step.loads, node_block(step, updated_, n), block.node,
                                  step.lagrangian() ? block_of(adj_displacement_, n) : nullptr);
}

template <class T>
void StepAdjoint<T>::reverse_contact(const TapeStep<T>& step, int n) {
  apply_object_contact_adjoint(step.loads, *step.grid, solver_.dx, before_contact_, n,
                               {adj_node_, by_contact_mass_, by_density_});
}

template <class T>
void StepAdjoint<T>::reverse_update(const TapeStep<T>& step, int n) {
  Node<T>* adj = block_of(adj_node_, n);
  node_sums_[n] = {};
  if (step.lagrangian()) return reverse_push(step, n);
  reverse_node_update(step.dt, step.loads, block_of(step.node, n), adj, node_sums_[n]);
  if (step.grid->has_siblings()) add_contact_masses(*step.grid, by_contact_mass_, n, adj);
}

template <class T>
void StepAdjoint<T>::reverse_scatter(const TapeStep<T>& step, int b) {
  if (step.lagrangian()) return reverse_impulses(step, b);
  alignas(64) Node<T> patch[2][BlockGrid::kPatchNodes];
  collect_patch(*step.grid, b, adj_node_, patch[0]);
  if (step.flip > T(0)) collect_patch(*step.grid, b, adj_old_node_, patch[1]);
  AdjointRun<T> run = run_of(step, b);
  const std::vector<T> loaded_v = loaded_velocities(step, b);
  run.loaded_v = loaded_v.empty() ? nullptr : loaded_v.data();
  const bool uniform = uniform_ != StressKind::kGiven && !(step.loads.viscosity_time > T(0));
  std::vector<T> stress, by_stress;
  if (!memory_.empty()) {
    stress.resize(6 * static_cast<size_t>(run.count));
    by_stress.resize(stress.size());
    for (int s = 0; s < run.count; ++s)
      if (const int side = record_[slot_[run.index[s]]].side; side >= 0)
        std::copy_n(step.given_stress.data() + 6 * side, 6, stress.data() + 6 * s);
    run.given_stress = stress.data();
    run.by_given_stress = by_stress.data();
  }
  kernels_.scatter[static_cast<int>(uniform ? uniform_ : StressKind::kGiven)](run, patch[0]->lane, patch[1]->lane);
  if (!memory_.empty()) reverse_given_stress(step, b, by_stress.data());
  if (!loaded_v.empty()) reverse_body_loads(step, b, step.particle.data() + step.begin[b], nullptr);
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
