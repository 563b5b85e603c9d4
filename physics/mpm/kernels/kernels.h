#pragma once

#include <cstdint>

#include "gaussians/simd/instruction_set.h"
#include "physics/mpm/kernels/elastic_run.h"

namespace pliant {

/// The particles of one block: record[order[0]] .. record[order[count - 1]].  Only plain data crosses into the files
/// of an instruction set.
template <class T>
struct ParticleRun {
  ParticleRecord<T>* record;
  const int* order;
  int count;
  T origin[3], dx, inverse_dx;
};

/// Nodes are four numbers, momentum or velocity and mass; a patch holds 6 x 6 x 6 of them, a block 4 x 4 x 4.
template <class T>
struct ScatterInput {
  ParticleRun<T> run;
  T dt;
  T viscosity_time;       ///< s, Kelvin-Voigt, for all particles
  bool inertia_only;      ///< leaves out the impulses of the stress, and damping
  const T* given_stress;  ///< [ParticleRecord::side, 6] xx, yy, zz, yz, xz, xy, Pa; with StressKind::kGiven
  /// Kirchhoff stress of one particle for any F, where the fast way is not safe (inverted, singular, very stretched).
  void (*exact_stress)(StressKind kind, const T* F, T mu, T lambda, T* tau);
};

template <class T>
struct GatherInput {
  ParticleRun<T> run;
  T dt;
  T low[3], high[3];     ///< m, bounds of the particles
  int block[3];          ///< coordinates of the block
  const T* node[8];      ///< velocities of the node blocks that the block's patch covers
  T flip;                ///< part kept of what the grid cannot represent of v and C, 0 = APIC
  const T* old_node[8];  ///< velocities before the step, where flip > 0
  T* grid_C;             ///< [count, 9] or null; where flip > 0 it receives the C of the grid, which moves F
  int* moved;            ///< [count], receives the places in the run whose particles left the block
};

template <class T>
struct GatherReport {
  T max_speed_squared;
  int particles, strays, moves;
  bool finite;
};

/// What follows from the nodes.
enum class Follow { kPlace, kMotion, kBoth };

/// How the speeds of nodes are measured: from the velocity `drift`, and times `seen`, which is min(1, 8 w) with w the
/// largest weight of a node in the motion of a particle.  Every particle has a node of w >= 1/8, so that rigid motion
/// is measured exactly, while nodes that particles hardly follow count little.
template <class T>
struct NodeFrame {
  T drift[3];     ///< m/s
  const T* seen;  ///< [64], in [0, 1]
};
template <class T>
struct NodeReport {
  T max_speed_squared;  ///< infinite where one is not finite
  T momentum[3];        ///< N s
  T low[3], high[3];    ///< m, bounds of the displacements of nodes that have mass; low > high where none has
};

/// The loops that depend on the instruction set.
template <class T>
struct MpmKernels {
  /// patch = sums of w m (v + C d) - dt V tau (4 / dx^2) w d and of w m.  One function for bodies of one law without
  /// damping or viscosity, by StressKind, and [2] for anything.
  void (*scatter[3])(const ScatterInput<T>&, T* patch);
  /// node += sum of the parts of up to eight patches (or null) that lie in this block of nodes.
  void (*add_nodes)(const T* const* patch, T* node);
  /// Momenta become velocities: v <- (v + fall) scale.
  void (*update_nodes)(T* node, const T* fall, T scale);
  /// v, C from the nodes, F <- (I + dt C) F and x <- x + dt v.
  void (*gather)(const GatherInput<T>&, GatherReport<T>&);
  /// Kirchhoff stress tau [count, 6] of F [count, 9] by the law `kind`.
  void (*stress)(StressKind kind, int count, const T* F, const T* mu, const T* lambda,
                 void (*exact_stress)(StressKind, const T*, T, T, T*), T* tau);

  /// Of Lagrangian runs: what particles give to the nodes of their block's patch within a step, their stress, the
  /// stabilization and the loads; by StressKind as in `scatter`.
  void (*elastic_impulses[3])(const ElasticRun<T>&, T* patch);
  /// [count] x and F, v and C, or both, which follow from the nodes.
  void (*follow_nodes)(const ElasticRun<T>&, Follow, TapeParticle<T>*);
  /// node += what the patch of one particle block has for some pairs of the node block.
  void (*add_pairs)(const ReachedPair*, int count, const T* patch, T* node);
  /// velocity <- (kept velocity + impulse / mass + fall) scale for the pairs of nodes in `active`, a bit each, of a
  /// node block [64, 4]; kept [64] or null.
  void (*push_nodes)(uint32_t active, const T* impulse, const T* kept, const T* fall, T scale, T* velocity);
  /// displacement += dt velocity for the pairs in `active`, `rest` being what rounding cuts off.
  void (*displace_nodes)(uint32_t active, const T* velocity, T dt, const NodeFrame<T>&, T* displacement, T* rest,
                         NodeReport<T>&);
};

template <class T>
const MpmKernels<T>& mpm_kernels(InstructionSet set);

namespace baseline {
template <class T>
const MpmKernels<T>& mpm_kernels();
}
namespace avx2 {
template <class T>
const MpmKernels<T>& mpm_kernels();
}

}  // namespace pliant
