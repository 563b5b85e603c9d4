#pragma once

#include <cstdint>

#include "gaussians/simd/instruction_set.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/kernels/tape_particle.h"

namespace pliant {

/// A particle in the reverse direction, in groups of four numbers like `ParticleRecord`.
template <class T>
struct alignas(64) AdjointRecord {
  T x[3], F[9];  ///< derivatives of L by the state at the end of the step that comes next
  T v[3], C[9];
  T mass, volume, mu, lambda;  ///< constants
  T shear_viscosity, bulk_viscosity, damping_rate, stress_kind;
  T by_mass, by_mu, by_lambda, by_viscosity_time;  ///< derivatives by constants, summed over the steps done
  T by_damping_rate;
  T viscosity_time;  ///< s, that of the material in both viscosities
  T put_back;        ///< sum of 1, 2, 4 for the axes along which that step put it into the domain
  T unused_number;
  T v_after[3], C_after[9];  ///< v and C at the end of that step
  uint32_t bits;             ///< load bits
  int32_t index, side;
  uint16_t material, unused;
};

// Offsets of the groups.
constexpr int kAdjointPlace = 0, kAdjointVelocity = 12, kAdjointConstant = 24, kAdjointDamping = 28, kAdjointSum = 32,
              kAdjointRest = 36, kAdjointAfter = 40;

/// Particles of one block in one step; only plain data crosses into the files of an instruction set.
template <class T>
struct AdjointRun {
  const TapeParticle<T>* particle;  ///< [count]
  const int* index;                 ///< [count] their numbers
  const int* slot;                  ///< [particles] place of a particle in `record`
  AdjointRecord<T>* record;
  int count;
  T dt, viscosity_time, origin[3], dx, inverse_dx, low[3], high[3];
  T flip;                 ///< as in GatherInput
  const T* by_grid_C;     ///< [count, 9] further derivatives by the C of the grid, or null
  const T* loaded_v;      ///< [count, 3] velocities with what the body loads gave, or null without loads
  const T* given_stress;  ///< [count, 6] of particles with StressKind::kGiven, as in ScatterInput
  T* by_given_stress;     ///< [count, 6] receives the derivatives by it
  void (*exact_stress)(StressKind kind, const T* F, T mu, T lambda, T* tau);
  /// by_F [9], by_lame [2] of S = dL/dtau (one side of the off-diagonal), where the fast way is not safe.
  void (*exact_adjoint)(StressKind kind, const T* F, T mu, T lambda, const T* S, T* by_F, T* by_lame);
};

template <class T>
struct AdjointKernels {
  /// Reverse of the gather: adds the derivatives by the node velocities `velocity` to `patch`, both [6, 6, 6] nodes;
  /// with flip > 0 the same for the velocities before the step.
  void (*gather)(const AdjointRun<T>&, const T* velocity, T* patch, const T* old_velocity, T* old_patch);
  /// Reverse of the scatter, from the derivatives `nodes` [6, 6, 6] by momentum and mass, with flip > 0 also by those
  /// of the inertia alone; by StressKind as in `MpmKernels::scatter`.  Leaves the derivatives by the loaded velocity in
  /// v.
  void (*scatter[3])(const AdjointRun<T>&, const T* nodes, const T* old_nodes);

  /// Reverse of elastic_impulses, from the derivatives `adj` [6, 6, 6] by impulse and, in the fourth lane, by mass.
  /// Those by displacement and velocity are written to two patches, those by the constants added to the records
  /// [count].
  void (*elastic_impulses[3])(const ElasticAdjointRun<T>&, const T* adj, AdjointRecord<T>*, T* by_displacement,
                              T* by_velocity);
  /// Reverse of follow_nodes, from the derivatives that the records [count] hold; adds to the patches.
  void (*follow_nodes)(const ElasticRun<T>&, const AdjointRecord<T>*, T* by_displacement, T* by_velocity);
};

template <class T>
const AdjointKernels<T>& adjoint_kernels(InstructionSet set);

namespace baseline {
template <class T>
const AdjointKernels<T>& adjoint_kernels();
}
namespace avx2 {
template <class T>
const AdjointKernels<T>& adjoint_kernels();
}

}  // namespace pliant
