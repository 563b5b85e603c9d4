#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/base/types.h"
#include "physics/mpm/block_grid.h"
#include "physics/mpm/node_conditions.h"

namespace pliant {

/// A particle in memory.  Kernels read eight numbers of eight particles at a time, so x..lambda are groups of eight;
/// matrices are row-major.
template <class T>
struct alignas(64) ParticleRecord {
  T x[3], F[9];            ///< m; elastic deformation gradient
  T mass, volume, mu, lambda;  ///< kg, m^3, Pa
  T v[3], C[9];            ///< m/s, 1/s
  T shear_viscosity, bulk_viscosity;  ///< Pa s
  T damping_rate;          ///< 1/s of mass-proportional damping: v decays with exp(-rate t)
  T stress_kind;           ///< see StressKind
  T x_rest[3], F_rest[9];  ///< what rounding cut off from x and F
  uint32_t bits;           ///< of the loads that act on it
  int32_t index;           ///< in the order of the particles
  uint16_t material, object;
  uint32_t unused;
};

/// What a solver holds between steps, for passes over it in other files.
template <class T>
struct MpmData {
  T dx = 0, inverse_dx = 0;
  Vec3<T> origin, low, high;  ///< m; nodes lie at origin + dx * integers, particles in [low, high]
  std::vector<ParticleRecord<T>> record;
  std::vector<int> slot;        ///< of particle i in `record`
  BlockGrid grid;               ///< grid.order() holds slots
  std::vector<Node<T>> patch;   ///< [particle blocks, 6, 6, 6], what a block scatters
  std::vector<Node<T>> node;    ///< [node blocks, 4, 4, 4], momentum and mass, after the update velocity and mass
};

}  // namespace pliant
