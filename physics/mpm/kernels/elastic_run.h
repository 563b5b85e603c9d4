#pragma once

#include "physics/mpm/kernels/particle_record.h"
#include "physics/mpm/kernels/tape_particle.h"

namespace pliant {

/// A particle of a Lagrangian run, of which nothing changes: its motion is that of the nodes.
template <class T>
struct RestParticle {
  T X[3], stabilization;                                   ///< m; N/m, see MpmOptions::stabilization
  T mass, volume, mu, lambda;                              ///< kg, m^3, Pa
  T shear_viscosity, bulk_viscosity, stress_kind, unused;  ///< as in ParticleRecord
};

/// Two neighbouring nodes of a block's patch [6, 6, 6] that its particles reach, and where they are among its eight
/// node blocks: numbers of pairs of nodes, along the last axis.
struct ReachedPair {
  uint8_t patch, block, node;
};

/// The particles of one block of a Lagrangian run, and the eight node blocks around them.  Only plain data crosses into
/// the files of an instruction set.
template <class T>
struct ElasticRun {
  const RestParticle<T>* particle;  ///< [count]
  const T* undisplaced;             ///< [count, 12] see MpmData, or null
  int count;
  const ReachedPair* pair;  ///< [pairs]
  int pairs;
  T origin[3], dx, inverse_dx;
  T dt, viscosity_time;                    ///< s; Kelvin-Voigt, for all particles
  bool viscous;                            ///< whether any stress depends on the strain rate
  const T* gain;                           ///< [count, 3] m/s, what loads give to the particles, or null
  const T *displacement[8], *velocity[8];  ///< of the node blocks, [64, 4] each; the fourth of velocity is the mass
  void (*exact_piola)(StressKind kind, const T* F, T mu, T lambda, T* P);  ///< [9], where the fast way is not safe
};

/// The same backwards.
template <class T>
struct ElasticAdjointRun {
  ElasticRun<T> run;
  T* by_gain;         ///< [count, 3] receives the derivatives by it, or null
  T* by_undisplaced;  ///< [count, 12] to which those by it are added, or null
  /// by_F [9], by_lame [2] from dL/dP [9], where the fast way is not safe.
  void (*exact_piola_adjoint)(StressKind kind, const T* F, T mu, T lambda, const T* adj_P, T* by_F, T* by_lame);
};

}  // namespace pliant
