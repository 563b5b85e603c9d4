#pragma once

#include <vector>

#include "gaussians/base/portable.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm_data.h"
#include "physics/mpm/node_sums.h"

// Transfers between the particles of a Lagrangian run and its nodes that are needed once per frame or for few
// particles.

namespace pliant {

constexpr int kBlocksAtOnce = 32;  ///< that are worth a thread

/// Visits the nodes of the stencil of rest position X: visit(place in the block's patch, weight, distance [m]).
template <class T, class Visit>
void for_stencil(const MpmData<T>& data, const Vec3<T>& X, Visit&& visit) {
  constexpr int kPatch = BlockGrid::kPatch;
  const auto along = [&](int a) { return Spline<T>((X[a] - data.origin[a]) * data.inverse_dx); };
  const Spline<T> sx = along(0), sy = along(1), sz = along(2);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        const Vec3<T> d(T(i) - sx.offset, T(j) - sy.offset, T(k) - sz.offset);
        visit((((sx.base & 3) + i) * kPatch + (sy.base & 3) + j) * kPatch + (sz.base & 3) + k,
              sx.weight[i] * sy.weight[j] * sz.weight[k], Vec3<T>(data.dx * d));
      }
}

/// [nodes] sums of what add(slot, weight, distance, lane of the node) gives for every particle and node of its stencil.
template <class T, class Add>
std::vector<Node<T>> sum_over_particles(const MpmData<T>& data, Add&& add) {
  std::vector<Node<T>> patches(static_cast<size_t>(data.grid.particle_blocks()) * BlockGrid::kPatchNodes, Node<T>{});
  std::vector<Node<T>> nodes(static_cast<size_t>(data.grid.node_blocks()) * BlockGrid::kNodes);
  const auto of_block = [&](std::ptrdiff_t b) {
    Node<T>* patch = patches.data() + static_cast<size_t>(b) * BlockGrid::kPatchNodes;
    for (int s = data.grid.begin(static_cast<int>(b)); s < data.grid.begin(static_cast<int>(b) + 1); ++s)
      for_stencil(data, data.reference[data.record[s].index],
                  [&](int at, T w, const Vec3<T>& d) { add(s, w, d, patch[at].lane); });
  };
  parallel_for(data.grid.particle_blocks(), of_block, kBlocksAtOnce);
  const MpmKernels<T>& kernels = mpm_kernels<T>(best_instruction_set());
  parallel_for(
      data.grid.node_blocks(),
      [&](std::ptrdiff_t n) { sum_patches(kernels, data.grid, static_cast<int>(n), patches, nodes); }, kBlocksAtOnce);
  return nodes;
}

/// Means over the particles, [nodes, 3], and their masses in the fourth lane.
template <class T, class Value>
std::vector<Node<T>> project(const MpmData<T>& data, Value&& value_at) {
  std::vector<Node<T>> nodes = sum_over_particles(data, [&](int s, T w, const Vec3<T>& d, T* lane) {
    const T m = w * data.rest[s].mass;
    const Vec3<T> value = m * value_at(data.record[s].index, d);
    for (int a = 0; a < 3; ++a) lane[a] += value[a];
    lane[3] += m;
  });
  for (Node<T>& node : nodes)
    for (int a = 0; a < 3; ++a) node.lane[a] = node.lane[3] > T(0) ? node.lane[a] / node.lane[3] : T(0);
  return nodes;
}

/// Displacements of the nodes from those of the particles, as velocities are transferred:
/// u_i = sum w m (u + (F - I) d) / sum w m.
template <class T>
std::vector<Node<T>> project_displacements(const MpmData<T>& data, const BasicSimulationState<T>& state) {
  return project(
      data, [&](int i, const Vec3<T>& d) -> Vec3<T> { return state.x[i] - data.reference[i] + (state.F[i] * d - d); });
}
/// Likewise velocities, sum w m (v + C d) / sum w m.
template <class T>
std::vector<Node<T>> project_velocities(const MpmData<T>& data, const BasicSimulationState<T>& state) {
  return project(data, [&](int i, const Vec3<T>& d) -> Vec3<T> { return state.v[i] + state.C[i] * d; });
}

/// What the nodes' values are at a particle: sum w a, and sum w a d^T [m], from which the gradient is 4 / dx^2 times
/// as much.
template <class T>
struct AtParticle {
  Vec3<T> value = Vec3<T>::Zero();
  Mat3<T> moment = Mat3<T>::Zero();
};

template <class T>
Vec3<T> three(const Node<T>& node) {
  return {node.lane[0], node.lane[1], node.lane[2]};
}

/// At the particle in slot s.
template <class T>
AtParticle<T> at_particle(const MpmData<T>& data, int s, const std::vector<Node<T>>& at_node) {
  AtParticle<T> of;
  const int b = data.block_of_slot[s];
  for_stencil(data, data.reference[data.record[s].index], [&](int at, T w, const Vec3<T>& d) {
    const Vec3<T> a = w * three(at_node[node_of_patch(data.grid, b, at)]);
    of.value += a;
    of.moment += a * d.transpose();
  });
  return of;
}

/// Of the particle in slot s, by the nodes: in one pass over its stencil, a node's four lanes at a time.
template <class T>
ParticlePlace<T> place_of(const MpmData<T>& data, int s, const std::vector<Node<T>>& displacement,
                          const std::vector<Node<T>>& velocity) {
  using Lanes = Eigen::Array<T, 4, 1>;
  Lanes u = Lanes::Zero(), v = Lanes::Zero();
  const Vec3<T>& X = data.reference[data.record[s].index];
  const int b = data.block_of_slot[s];
  for_stencil(data, X, [&](int at, T w, const Vec3<T>&) {
    const size_t node = node_of_patch(data.grid, b, at);
    u += w * Eigen::Map<const Lanes>(displacement[node].lane);
    v += w * Eigen::Map<const Lanes>(velocity[node].lane);
  });
  Vec3<T> x = X + u.matrix().template head<3>();
  if (!data.undisplaced.empty()) x += Eigen::Map<const Vec3<T>>(data.undisplaced.data() + 12 * static_cast<size_t>(s));
  return {x, v.matrix().template head<3>()};
}

/// Calls visit(slot, AtParticle of the first three lanes of `at_node` [nodes]) for every particle.
template <class T, class Visit>
void for_particles(const MpmData<T>& data, const std::vector<Node<T>>& at_node, Visit&& visit) {
  const auto of_block = [&](std::ptrdiff_t b) {
    for (int s = data.grid.begin(static_cast<int>(b)); s < data.grid.begin(static_cast<int>(b) + 1); ++s)
      visit(s, at_particle(data, s, at_node));
  };
  parallel_for(data.grid.particle_blocks(), of_block, kBlocksAtOnce);
}

/// The particles of block b for the kernels, with the motion of these nodes; step and stress are left to the caller.
template <class T>
ElasticRun<T> run_of_block(const MpmData<T>& data, int b, const std::vector<Node<T>>& displacement,
                           const std::vector<Node<T>>& velocity) {
  const size_t begin = static_cast<size_t>(data.grid.begin(b)), list = 8 * static_cast<size_t>(b);
  ElasticRun<T> run{};
  run.particle = data.rest.data() + begin;
  run.undisplaced = data.undisplaced.empty() ? nullptr : data.undisplaced.data() + 12 * begin;
  run.count = data.grid.begin(b + 1) - data.grid.begin(b);
  run.pair = data.pair.data() + data.pair_begin[list];
  run.pairs = data.pair_begin[list + 8] - data.pair_begin[list];
  for (int a = 0; a < 3; ++a) run.origin[a] = data.origin[a];
  run.dx = data.dx;
  run.inverse_dx = data.inverse_dx;
  for (int o = 0; o < 8; ++o) {
    const size_t node = static_cast<size_t>(data.grid.nodes_of(b)[o]) * BlockGrid::kNodes;
    run.displacement[o] = displacement[node].lane;
    run.velocity[o] = velocity[node].lane;
  }
  return run;
}

}  // namespace pliant
