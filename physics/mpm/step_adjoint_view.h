#pragma once

#include <cstdint>

#include "physics/mpm/node_conditions.h"
#include "physics/mpm/step_tape.h"

namespace pliant {

/// A particle in the reverse direction: derivatives of L, and the constants that they need.
template <class T>
struct AdjointRecord {
  T x[3], v[3], C[9], F[9];        ///< by the state at the end of the step that comes next
  T v_after[3], C_after[9];        ///< v and C at the end of that step
  T mass, volume, mu, lambda;
  T by_mass, by_mu, by_lambda;     ///< summed over the steps done
  uint32_t bits;                   ///< load bits
  uint32_t put_back;               ///< bit a: that step put the particle back into the domain along axis a
  int index;
};

template <class T>
struct PlainBodyLoad {
  uint32_t bit;
  T acceleration[3], drag;
};

/// One step for the kernels, which are compiled per instruction set and see no containers.
template <class T>
struct AdjointView {
  T dt, dx, inverse_dx, viscosity_time;
  T origin[3], low[3], high[3];
  const TapeParticle<T>* particle;  ///< [N] in the order of the blocks
  const int* index;                 ///< [N] their numbers
  const int* slot;                  ///< [N] place of a particle in `record`
  AdjointRecord<T>* record;
  const PlainBodyLoad<T>* body;
  int bodies;
};

/// Sums over the particles of a block, for the derivatives by loads: viscosity time, then four per body load.
constexpr int kAdjointSums(int bodies) { return 1 + 4 * bodies; }

template <class T>
struct AdjointKernels {
  /// Reverse of the gather of particles [first, last): fills `patch` with derivatives by the node velocities
  /// `velocity`, both [6, 6, 6] of the block.
  void (*gather)(const AdjointView<T>& view, int first, int last, const Node<T>* velocity, Node<T>* patch);
  /// Reverse of the scatter, from the derivatives `nodes` [6, 6, 6] by momentum and mass.
  void (*scatter)(const AdjointView<T>& view, int first, int last, const Node<T>* nodes, double* sums);
};

}  // namespace pliant
