#pragma once

#include <vector>

#include "gaussians/base/portable.h"
#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm_data.h"
#include "physics/mpm/node_sums.h"

// Transfers between the particles of a Lagrangian run and its nodes that are needed once per frame.

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

template <class T>
struct ProjectedDisplacements {
  std::vector<Vec3<T>> displacement;  ///< [nodes] m
  std::vector<T> mass;                ///< [nodes] kg
};

/// Displacements of the nodes from those of the particles, as velocities are transferred:
/// u_i = sum w m (u + (F - I) d) / sum w m.
template <class T>
ProjectedDisplacements<T> project_displacements(const MpmData<T>& data, const BasicSimulationState<T>& state) {
  const std::vector<Node<T>> sums = sum_over_particles(data, [&](int s, T w, const Vec3<T>& d, T* lane) {
    const int i = data.record[s].index;
    const T m = w * data.record[s].mass;
    const Vec3<T> u = state.x[i] - data.reference[i] + (state.F[i] * d - d);
    for (int a = 0; a < 3; ++a) lane[a] += m * u[a];
    lane[3] += m;
  });
  ProjectedDisplacements<T> result{std::vector<Vec3<T>>(sums.size(), Vec3<T>::Zero()), std::vector<T>(sums.size())};
  for (size_t i = 0; i < sums.size(); ++i) {
    const T* sum = sums[i].lane;
    result.mass[i] = sum[3];
    if (sum[3] > T(0)) result.displacement[i] = Vec3<T>(sum[0], sum[1], sum[2]) / sum[3];
  }
  return result;
}

/// What the nodes' values are at a particle: sum w a, and sum w a d^T [m], from which the gradient is 4 / dx^2 times
/// as much.
template <class T>
struct AtParticle {
  Vec3<T> value = Vec3<T>::Zero();
  Mat3<T> moment = Mat3<T>::Zero();
};

/// Calls visit(slot, AtParticle of the nodes' values `at_node` [nodes, 3]) for every particle.
template <class T, class Visit>
void for_particles(const MpmData<T>& data, const std::vector<Vec3<T>>& at_node, Visit&& visit) {
  const auto of_block = [&](std::ptrdiff_t b) {
    Vec3<T> patch[BlockGrid::kPatchNodes];
    collect_patch(data.grid, static_cast<int>(b), at_node, patch);
    for (int s = data.grid.begin(static_cast<int>(b)); s < data.grid.begin(static_cast<int>(b) + 1); ++s) {
      AtParticle<T> of;
      for_stencil(data, data.reference[data.record[s].index], [&](int at, T w, const Vec3<T>& d) {
        of.value += w * patch[at];
        of.moment += w * patch[at] * d.transpose();
      });
      visit(s, of);
    }
  };
  parallel_for(data.grid.particle_blocks(), of_block, kBlocksAtOnce);
}

}  // namespace pliant
