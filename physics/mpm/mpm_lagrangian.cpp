// Lagrangian runs: nodes belong to the body at rest and carry its motion, which particles follow.

#include <algorithm>
#include <cmath>
#include <limits>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {

template <class T>
void exact_piola(StressKind kind, const T* F, T mu, T lambda, T* P) {
  using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
  Eigen::Map<RowMajor>{P} = piola_stress<T>({&plain_material(kind), mu, lambda}, Eigen::Map<const RowMajor>(F));
}
template void exact_piola(StressKind, const float*, float, float, float*);
template void exact_piola(StressKind, const double*, double, double, double*);

template <class T>
ElasticRun<T> Mpm<T>::elastic_run(int b, T dt, const StepLoads<T>& loads) const {
  ElasticRun<T> run = run_of_block(data_, b, data_.node_displacement, data_.node_velocity);
  run.dt = dt;
  run.viscosity_time = loads.viscosity_time;
  run.viscous = viscous_ || loads.viscosity_time > T(0);
  run.exact_piola = exact_piola<T>;
  return run;
}

/// What the loads give to the particles of a block.
template <class T>
void Mpm<T>::find_gains(int b, T dt, const StepLoads<T>& loads) {
  const int begin = data_.grid.begin(b), count = data_.grid.begin(b + 1) - begin;
  thread_local std::vector<TapeParticle<T>> now;
  now.assign(count, {});
  const bool place = std::any_of(loads.body.begin(), loads.body.end(), reads_place<T>);
  const bool motion = std::any_of(loads.body.begin(), loads.body.end(), reads_motion<T>);
  if (place || motion)
    kernels_->follow_nodes(elastic_run(b, dt, loads),
                           place && motion ? Follow::kBoth
                           : place         ? Follow::kPlace
                                           : Follow::kMotion,
                           now.data());
  for (int i = 0; i < count; ++i) {
    const ParticleRecord<T>& r = data_.record[begin + i];
    Vec3<T>& sum = gain_[begin + i];
    if (r.bits == 0) continue;
    const LoadedParticle<T> p = loaded_particle(data_, r, now[i].x, now[i].v, now[i].F);
    for (size_t l = 0; l < loads.body.size(); ++l) {
      if ((r.bits & loads.body[l].bit) == 0) continue;
      const Vec3<T> gain = velocity_gain(loads.body[l], dt, p);
      sum += gain;
      particle_impulse_[b * loads.body.size() + l] += static_cast<double>(r.mass) * gain.template cast<double>();
    }
  }
}

template <class T>
void Mpm<T>::follow_block(int b) {
  const int begin = data_.grid.begin(b), count = data_.grid.begin(b + 1) - begin;
  std::vector<TapeParticle<T>> now(count);
  kernels_->follow_nodes(elastic_run(b, T(0), {}), Follow::kBoth, now.data());
  for (int i = 0; i < count; ++i) {
    where_[begin + i] = Eigen::Map<const Vec3<T>>(now[i].x);
    moving_[begin + i] = Eigen::Map<const Vec3<T>>(now[i].v);
  }
}

/// What particles near those of a block give to them.
template <class T>
void Mpm<T>::add_contacts(int b, T dt, const StepLoads<T>& loads) {
  for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s)
    gain_[s] += contact_gain<T>(data_, contacts_, s, where_, moving_, dt, static_cast<T>(loads.object_friction));
}

template <class T>
void Mpm<T>::elastic_block(int b, T dt, const StepLoads<T>& loads) {
  ElasticRun<T> run = elastic_run(b, dt, loads);
  const bool loaded = loaded_[b] && !loads.body.empty(), touches = touching() && contacts_.block_touches()[b];
  if (loaded || touches) {
    std::fill_n(gain_.begin() + data_.grid.begin(b), run.count, Vec3<T>::Zero());
    run.gain = gain_[data_.grid.begin(b)].data();
  }
  if (loaded) find_gains(b, dt, loads);
  if (touches) add_contacts(b, dt, loads);
  const bool uniform = uniform_ != StressKind::kGiven && !run.viscous;
  kernels_->elastic_impulses[static_cast<int>(uniform ? uniform_ : StressKind::kGiven)](
      run, data_.patch[static_cast<size_t>(b) * BlockGrid::kPatchNodes].lane);
}

/// Shares of their velocity that nodes keep in a step, by the damping of the material.
template <class T>
void Mpm<T>::find_kept(T dt) {
  if (data_.node_damping.empty() || dt == kept_dt_) return;
  kept_dt_ = dt;
  kept_.resize(data_.node_damping.size());
  for (size_t i = 0; i < kept_.size(); ++i) kept_[i] = std::exp(-dt * data_.node_damping[i]);
}

template <class T>
void Mpm<T>::displace_node_block(int n, T dt) {
  const size_t first = static_cast<size_t>(n) * BlockGrid::kNodes;
  const NodeFrame<T> frame{{drift_[0], drift_[1], drift_[2]}, data_.node_seen.data() + first};
  kernels_->displace_nodes(data_.active[n], data_.node_velocity[first].lane, dt, frame,
                           data_.node_displacement[first].lane, data_.node_displacement_rest[first].lane,
                           node_report_[n]);
}

/// Speeds are measured from the mean velocity of the step before, so that it does not matter how fast a body falls.
template <class T>
void Mpm<T>::collect_node_reports() {
  T fastest = 0;
  Vec3d momentum = Vec3d::Zero();
  for (const NodeReport<T>& report : node_report_) {
    fastest = std::max(fastest, report.max_speed_squared);
    momentum += Vec3d(report.momentum[0], report.momentum[1], report.momentum[2]);
  }
  finite_ &= std::isfinite(fastest);
  updates_ += static_cast<int64_t>(data_.record.size());
  max_speed_ = std::sqrt(static_cast<double>(fastest));
  drift_ = (momentum / mass_).template cast<T>();
}

/// Which nodes the particles reach, in pairs along the last axis.
template <class T>
void Mpm<T>::find_pairs() {
  constexpr int kSide = BlockGrid::kSide, kRows = BlockGrid::kPatch, kPairs = BlockGrid::kPatch / 2;
  data_.pair.clear();
  data_.pair_begin.assign(1, 0);
  data_.active.assign(data_.grid.node_blocks(), 0);
  for (int b = 0; b < data_.grid.particle_blocks(); ++b) {
    bool reached[kRows * kRows * kPairs] = {};
    for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s)
      for_stencil(data_, data_.reference[data_.record[s].index],
                  [&](int at, T, const Vec3<T>&) { reached[at / 2] = true; });
    for (int o = 0; o < 8; ++o) {
      for (int p = 0; p < kRows * kRows * kPairs; ++p) {
        const int i = p / (kRows * kPairs), j = p / kPairs % kRows, k = 2 * (p % kPairs);
        if (!reached[p] || o != ((i >= kSide) << 2 | (j >= kSide) << 1 | (k >= kSide))) continue;
        const int node = ((i % kSide) * kSide + j % kSide) * kSide / 2 + k % kSide / 2;
        data_.pair.push_back({static_cast<uint8_t>(p), static_cast<uint8_t>(o), static_cast<uint8_t>(node)});
        data_.active[data_.grid.nodes_of(b)[o]] |= 1u << node;
      }
      data_.pair_begin.push_back(static_cast<int>(data_.pair.size()));
    }
  }
}

/// What the particles at rest, in their order in memory, are to the nodes.
template <class T>
void Mpm<T>::find_rest_constants() {
  const size_t slots = data_.record.size();
  const T share = static_cast<T>(2 * options_.stabilization) * data_.inverse_dx * data_.inverse_dx;
  data_.rest.resize(slots);
  data_.block_of_slot.resize(slots);
  for (int b = 0; b < data_.grid.particle_blocks(); ++b)
    std::fill(data_.block_of_slot.begin() + data_.grid.begin(b), data_.block_of_slot.begin() + data_.grid.begin(b + 1),
              b);
  find_pairs();
  bool damped = false;
  mass_ = 0;
  for (size_t s = 0; s < slots; ++s) {
    const ParticleRecord<T>& r = data_.record[s];
    const Vec3<T>& X = data_.reference[r.index];
    data_.rest[s] = {{X[0], X[1], X[2]}, share * r.mu * r.volume, r.mass,           r.volume,      r.mu,
                     r.lambda,           r.shear_viscosity,       r.bulk_viscosity, r.stress_kind, T(0)};
    mass_ += r.mass;
    damped |= r.damping_rate > T(0);
  }
  data_.node_seen.assign(data_.node.size(), T(0));
  data_.node_filled.assign(data_.node.size(), T(0));
  const T per_cell = data_.inverse_dx * data_.inverse_dx * data_.inverse_dx;
  for (int b = 0; b < data_.grid.particle_blocks(); ++b)
    for (int s = data_.grid.begin(b); s < data_.grid.begin(b + 1); ++s)
      for_stencil(data_, data_.reference[data_.record[s].index], [&](int at, T w, const Vec3<T>&) {
        const size_t node = node_of_patch(data_.grid, b, at);
        data_.node_seen[node] = std::max(data_.node_seen[node], std::min(T(1), 8 * w));
        data_.node_filled[node] += w * data_.record[s].volume * per_cell;
      });
  gain_.resize(slots);
  where_.resize(slots);
  moving_.resize(slots);
  data_.node_displacement_rest.resize(data_.node.size());
  if (!damped) return;
  const std::vector<Node<T>> rates = project(data_, [&](int i, const Vec3<T>&) -> Vec3<T> {
    return {rest_[i].damping_rate, T(0), T(0)};
  });
  data_.node_damping.resize(rates.size());
  for (size_t i = 0; i < rates.size(); ++i) data_.node_damping[i] = rates[i].lane[0];
}

/// Displacements and velocities of the nodes: those of the state, or where it has none, as at a start, what the
/// particles make of them.
template <class T>
void Mpm<T>::load_nodes(const BasicSimulationState<T>& state) {
  const size_t nodes = data_.node.size();
  contacts_.clear();
  loaded_.assign(data_.grid.particle_blocks(), 0);
  for (size_t s = 0; s < data_.record.size(); ++s) loaded_[data_.block_of_slot[s]] |= data_.record[s].bits != 0;
  std::fill(data_.node_displacement_rest.begin(), data_.node_displacement_rest.end(), Node<T>{});
  if (state.node_velocity.empty()) {
    data_.node_displacement = project_displacements(data_, state);
    for (Node<T>& node : data_.node_displacement) node.lane[3] = T(0);
    data_.node_velocity = project_velocities(data_, state);
  } else {
    CHECK(state.node_velocity.size() == nodes && state.node_displacement.size() == nodes);
    if (data_.node_velocity.empty()) data_.node_velocity = project_velocities(data_, state);  // for the masses
    data_.node_displacement.resize(nodes);
    for (size_t i = 0; i < nodes; ++i)
      for (int a = 0; a < 3; ++a) {
        data_.node_displacement[i].lane[a] = state.node_displacement[i][a];
        data_.node_velocity[i].lane[a] = state.node_velocity[i][a];
      }
  }
  Vec3d momentum = Vec3d::Zero();
  for (const Node<T>& node : data_.node_velocity) momentum += node.lane[3] * three(node).template cast<double>();
  drift_ = (momentum / mass_).template cast<T>();
  for (int n = 0; n < data_.grid.node_blocks(); ++n) displace_node_block(n, T(0));  // for the reports alone
  find_undisplaced();
}

/// Each particle's place and deformation gradient less what the displacements of the nodes make of them, where that is
/// more than rounding.
template <class T>
void Mpm<T>::find_undisplaced() {
  const T rounding = 64 * std::numeric_limits<T>::epsilon();
  std::vector<T> left(12 * data_.record.size());
  std::vector<uint8_t> notable(data_.grid.particle_blocks());
  data_.undisplaced.clear();
  const auto of_block = [&](std::ptrdiff_t block) {
    const int b = static_cast<int>(block), begin = data_.grid.begin(b);
    std::vector<TapeParticle<T>> now(data_.grid.begin(b + 1) - begin);
    kernels_->follow_nodes(elastic_run(b, T(0), {}), Follow::kPlace, now.data());
    for (size_t k = 0; k < now.size(); ++k) {
      const ParticleRecord<T>& r = data_.record[begin + k];
      T* to = left.data() + 12 * (begin + k);
      T moved = 0;
      for (int a = 0; a < 3; ++a) moved = std::max(moved, std::abs(r.x[a] - data_.rest[begin + k].X[a]));
      for (int a = 0; a < 3; ++a) {
        to[a] = r.x[a] - now[k].x[a];
        notable[b] |= std::abs(to[a]) > rounding * (std::abs(r.x[a]) + moved + data_.dx);
      }
      for (int i = 0; i < 9; ++i) {
        to[3 + i] = r.F[i] - now[k].F[i];
        notable[b] |= std::abs(to[3 + i]) > rounding * (1 + std::abs(r.F[i]) + moved / data_.dx);
      }
    }
  };
  parallel_for(data_.grid.particle_blocks(), of_block, kBlocksAtOnce);
  if (std::find(notable.begin(), notable.end(), 1) != notable.end()) data_.undisplaced = std::move(left);
}

template <class T>
void Mpm<T>::store_nodes(BasicSimulationState<T>& state) const {
  const size_t nodes = data_.node.size();
  parallel_for(
      data_.grid.particle_blocks(),
      [&](std::ptrdiff_t block) {
        const int b = static_cast<int>(block), begin = data_.grid.begin(b);
        std::vector<TapeParticle<T>> now(data_.grid.begin(b + 1) - begin);
        kernels_->follow_nodes(elastic_run(b, T(0), {}), Follow::kBoth, now.data());
        using RowMajor = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
        for (size_t k = 0; k < now.size(); ++k) {
          const int i = data_.record[begin + k].index;
          state.x[i] = Eigen::Map<const Vec3<T>>(now[k].x);
          state.v[i] = Eigen::Map<const Vec3<T>>(now[k].v);
          state.F[i] = Eigen::Map<const RowMajor>(now[k].F);
          state.C[i] = Eigen::Map<const RowMajor>(now[k].C);
        }
      },
      kBlocksAtOnce);
  state.node_displacement.resize(nodes);
  state.node_velocity.resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    state.node_displacement[i] = three(data_.node_displacement[i]);
    state.node_velocity[i] = three(data_.node_velocity[i]);
  }
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
