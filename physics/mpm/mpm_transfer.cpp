#include <algorithm>
#include <cmath>

#include "physics/mpm/mpm.h"
#include "physics/mpm/node_sums.h"

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;

/// The stress of a law with nothing but Lame parameters, for any F.
template <class T>
void exact_stress(StressKind kind, const T* F, T mu, T lambda, T* tau) {
  const LawPoint<T> point{&plain_material(kind), mu, lambda};
  const Mat3<T> stress =
      kirchhoff_stress<T>(point, Eigen::Map<const Eigen::Matrix<T, 3, 3, Eigen::RowMajor>>(F), LawMemory<T>{});
  tau[0] = stress(0, 0);
  tau[1] = stress(1, 1);
  tau[2] = stress(2, 2);
  tau[3] = stress(1, 2);
  tau[4] = stress(0, 2);
  tau[5] = stress(0, 1);
}

}  // namespace

template <class T>
ParticleRun<T> Mpm<T>::run_of(int b) {
  const int begin = data_.grid.begin(b);
  return {data_.record.data(),
          data_.grid.order().data() + begin,
          data_.grid.begin(b + 1) - begin,
          {data_.origin[0], data_.origin[1], data_.origin[2]},
          data_.dx,
          data_.inverse_dx};
}

/// What the loads give to single particles.
template <class T>
void Mpm<T>::apply_body_loads(int b, T dt, const StepLoads<T>& loads) {
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s) {
    ParticleRecord<T>& r = data_.record[data_.grid.order()[s]];
    if (r.bits == 0) continue;
    LoadedParticle<T> p = loaded_particle(data_, r, r.x, r.v, r.F);
    if (has_memory(data_, r)) p.F = data_.side[r.side].memory.F_total;
    Vec3<T> sum = Vec3<T>::Zero();
    for (size_t l = 0; l < loads.body.size(); ++l) {
      if ((r.bits & loads.body[l].bit) == 0) continue;
      const Vec3<T> gain = velocity_gain(loads.body[l], dt, p);
      sum += gain;
      particle_impulse_[b * loads.body.size() + l] += static_cast<double>(r.mass) * gain.template cast<double>();
    }
    for (int a = 0; a < 3; ++a) r.v[a] += sum[a];
  }
}

template <class T>
void Mpm<T>::scatter_block(int b, T dt, const StepLoads<T>& loads) {
  if (options_.lagrangian) return elastic_block(b, dt, loads);
  if (sleeping() && scatter_can_wait(b, dt, loads)) return;
  if (!loads.body.empty()) apply_body_loads(b, dt, loads);
  ScatterInput<T> in;
  in.run = run_of(b);
  in.dt = dt;
  in.viscosity_time = loads.viscosity_time;
  in.inertia_only = false;
  in.given_stress = data_.given_stress.data();
  in.exact_stress = exact_stress<T>;
  const bool uniform = uniform_ != StressKind::kGiven && !(loads.viscosity_time > T(0));
  const int which = static_cast<int>(uniform ? uniform_ : StressKind::kGiven);
  const size_t patch = static_cast<size_t>(b) * BlockGrid::kPatchNodes;
  kernels_->scatter[which](in, data_.patch[patch].lane);
  if (!(options_.flip_time > 0)) return;
  in.inertia_only = true;
  kernels_->scatter[which](in, data_.old_patch[patch].lane);
}

template <class T>
void Mpm<T>::sum_node_block(int n) {
  if (options_.lagrangian)
    sum_pairs(*kernels_, data_, n, data_.patch, data_.node);
  else
    sum_patches(*kernels_, data_.grid, n, data_.patch, data_.node);
  if (!(options_.flip_time > 0)) return;
  const T none[3] = {};
  kernels_->update_nodes(sum_patches(*kernels_, data_.grid, n, data_.old_patch, data_.old_node)->lane, none, T(1));
}

template <class T>
void Mpm<T>::update_node_block(int n, T dt, const StepLoads<T>& loads) {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  const T fall[3] = {dt * loads.gravity[0], dt * loads.gravity[1], dt * loads.gravity[2]};
  if (options_.lagrangian)
    kernels_->push_nodes(data_.active[n], data_.node[first].lane, kept_.empty() ? nullptr : kept_.data() + first, fall,
                         loads.velocity_scale, data_.node_velocity[first].lane);
  else
    kernels_->update_nodes(data_.node[first].lane, fall, loads.velocity_scale);
}

template <class T>
void Mpm<T>::apply_conditions(int n, const StepLoads<T>& loads) {
  const BlockGrid::Coordinates& block = data_.grid.node_block(n);
  const double dx = data_.dx;
  const Vec3d corner = data_.origin.template cast<double>() + dx * kSide * Vec3d(block.x, block.y, block.z);
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  const NodeBlock<T> nodes = options_.lagrangian ? NodeBlock<T>{data_.node_velocity.data() + first,
                                                                corner,
                                                                dx,
                                                                block.object,
                                                                data_.node_displacement.data() + first,
                                                                data_.node_filled.data() + first,
                                                                node_report_[n].low,
                                                                node_report_[n].high}
                                                 : NodeBlock<T>{data_.node.data() + first, corner, dx, block.object};
  apply_node_conditions<T>(
      loads, nodes, node_impulse_.data() + static_cast<size_t>(n) * (loads.colliders.size() + loads.pins.size()));
}

/// Conditions on the updated velocities of a block, and how they move for those who may sleep.
template <class T>
void Mpm<T>::condition_node_block(int n, T dt, const StepLoads<T>& loads) {
  apply_conditions(n, loads);
  if (options_.lagrangian) displace_node_block(n, dt);
  if (sleeping()) measure_motion(n);
}

/// Damps the affine part of the particles' velocity.
template <class T>
void Mpm<T>::damp_affine(int b, T strain_rate_kept, T spin_kept) {
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s) {
    T* C = data_.record[data_.grid.order()[s]].C;
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j) {
        const T symmetric = strain_rate_kept * T(0.5) * (C[3 * i + j] + C[3 * j + i]);
        const T spin = spin_kept * T(0.5) * (C[3 * i + j] - C[3 * j + i]);
        C[3 * i + j] = symmetric + spin;
        C[3 * j + i] = symmetric - spin;
      }
    }
  }
}

template <class T>
T Mpm<T>::flip(T dt) const {
  return options_.flip_time > 0 ? static_cast<T>(std::exp(-static_cast<double>(dt) / options_.flip_time)) : T(0);
}

template <class T>
void Mpm<T>::gather_block(int b, T dt, const StepLoads<T>& loads) {
  if (sleeping() && gather_can_wait(b, dt)) return;
  GatherInput<T> in{};
  in.run = run_of(b);
  in.dt = dt;
  const BlockGrid::Coordinates& block = data_.grid.block(b);
  const int coordinates[3] = {block.x, block.y, block.z};
  for (int a = 0; a < 3; ++a) {
    in.low[a] = data_.low[a];
    in.high[a] = data_.high[a];
    in.block[a] = coordinates[a];
  }
  in.flip = flip(dt);
  for (int o = 0; o < 8; ++o) {
    const size_t node = static_cast<size_t>(data_.grid.nodes_of(b)[o]) * BlockGrid::kNodes;
    in.node[o] = data_.node[node].lane;
    in.old_node[o] = in.flip > T(0) ? data_.old_node[node].lane : nullptr;
  }
  in.moved = moved_.data() + data_.grid.begin(b);
  std::vector<T> grid_C(data_.side.empty() || !(in.flip > T(0)) ? 0 : 9 * static_cast<size_t>(in.run.count));
  in.grid_C = grid_C.empty() ? nullptr : grid_C.data();
  kernels_->gather(in, report_[b]);
  if (!data_.side.empty()) apply_laws(b, dt, in.grid_C);
  if (loads.strain_rate_kept != T(1) || loads.spin_kept != T(1))
    damp_affine(b, loads.strain_rate_kept, loads.spin_kept);
  if (sleeping()) watch_rest(b, dt);
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
