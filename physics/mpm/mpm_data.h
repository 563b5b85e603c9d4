#pragma once

#include <vector>

#include "gaussians/base/types.h"
#include "physics/mpm/block_grid.h"
#include "physics/mpm/kernels/elastic_run.h"
#include "physics/mpm/node_conditions.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// What a particle remembers whose law is not one of the kernels'.
template <class T>
struct LawSide {
  LawMemory<T> memory;
  T total_rest[9];  ///< what rounding cut off from memory.F_total
};

/// What decides whether a block sleeps.
template <class T>
struct NodeMotion {
  T speed_squared = 0, sum[3] = {};  ///< largest of, and sum over, the nodes of a block
};
template <class T>
struct BlockRest {
  T quiet_time = 0;                      ///< s since something in the block or near it moved
  T max_speed_squared = 0;               ///< when it fell asleep
  T patch_dt = 0;                        ///< step for which the block's patch holds, 0 = none
  bool asleep = false, settled = false;  ///< settled: `at_sleep` holds
  NodeMotion<T> at_sleep[8];
};

/// What a solver holds between steps, for passes over it in other files.
template <class T>
struct MpmData {
  T dx = 0, inverse_dx = 0;
  Vec3<T> origin, low, high;  ///< m; nodes lie at origin + dx * integers, particles in [low, high]
  std::vector<ParticleRecord<T>> record;
  std::vector<Vec3<T>> reference, exposure;  ///< [N] in the order of the particles, see LoadedParticle
  std::vector<int> slot;                     ///< of particle i in `record`
  BlockGrid grid;                            ///< grid.order() holds slots
  std::vector<Material> materials;
  std::vector<LawSide<T>> side;  ///< by ParticleRecord::side
  std::vector<T> given_stress;   ///< [side, 6] Kirchhoff stress xx, yy, zz, yz, xz, xy, Pa
  std::vector<Node<T>> patch;    ///< [particle blocks, 6, 6, 6], what a block scatters
  std::vector<Node<T>> node;     ///< [node blocks, 4, 4, 4], momentum and mass, after the update velocity and mass
  std::vector<Node<T>> old_patch, old_node;  ///< the same without forces and loads; with MpmOptions::flip_time only

  /// Of Lagrangian runs, whose motion is that of the nodes, else empty.  `node` holds impulses there.
  std::vector<RestParticle<T>> rest;       ///< [slots]
  std::vector<ReachedPair> pair;           ///< of the particle blocks, by node block within each
  std::vector<int> pair_begin;             ///< [particle blocks, 8] and the end
  std::vector<uint32_t> active;            ///< [node blocks] pairs that have mass
  std::vector<int> block_of_slot;          ///< [slots] particle block
  std::vector<T> undisplaced;              ///< [slots, 12] x and F less what the nodes say of them; empty = nothing
  std::vector<Node<T>> node_velocity;      ///< [nodes = node blocks, 4, 4, 4] m/s, and mass
  std::vector<Node<T>> node_displacement;  ///< [nodes] m
  std::vector<Node<T>> node_displacement_rest;  ///< [nodes] what rounding cut off from it
  std::vector<T> node_damping;                  ///< [nodes] 1/s, mean of the particles'; empty = none
  std::vector<T> node_seen;                     ///< [nodes] see NodeFrame::seen
  std::vector<T> node_filled;                   ///< [nodes] share of a cell's volume that hangs on each at rest
};

/// Where a particle is and how it moves.
template <class T>
struct ParticlePlace {
  Vec3<T> x, v;  ///< m, m/s
};

/// Whether the whole deformation of a particle is that of its memory instead of its F.
template <class T, class Record>
bool has_memory(const MpmData<T>& data, const Record& constants) {
  return constants.side >= 0 && has_memory(data.materials[constants.material].law);
}

/// What loads read of particle `index`, in the fields that ParticleRecord and AdjointRecord share; F as it is where the
/// particle has no memory.
template <class T, class Record>
LoadedParticle<T> loaded_particle(const MpmData<T>& data, const Record& constants, const T* x, const T* v, const T* F) {
  const auto& r = constants;
  const T modulus = WaveModulus(data.materials[r.material])(r.mu, r.lambda);
  return {{x[0], x[1], x[2]},
          {v[0], v[1], v[2]},
          data.reference[r.index],
          Eigen::Map<const Eigen::Matrix<T, 3, 3, Eigen::RowMajor>>(F),
          data.exposure.empty() ? Vec3<T>(Vec3<T>::Zero()) : data.exposure[r.index],
          r.mass,
          r.volume,
          modulus * r.volume / r.mass * data.inverse_dx * data.inverse_dx};
}

}  // namespace pliant
