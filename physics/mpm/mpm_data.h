#pragma once

#include <vector>

#include "gaussians/base/types.h"
#include "physics/mpm/block_grid.h"
#include "physics/mpm/node_conditions.h"
#include "physics/mpm/particle_record.h"

namespace pliant {

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
