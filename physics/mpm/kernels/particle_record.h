#pragma once

#include <cstdint>

namespace pliant {

/// How a kernel comes to the stress of a particle; kHencky in Lagrangian runs alone, elsewhere it is given.
enum class StressKind { kFixedCorotated, kNeoHookean, kGiven, kHencky };

/// A particle in memory.  Kernels read four numbers of several particles at a time, so the numbers come in groups of
/// four, named below by their first; those that the scatter reads come first.  Matrices are row-major.
template <class T>
struct alignas(64) ParticleRecord {
  T x[3], F[9];                       ///< m; elastic deformation gradient
  T mass, volume, mu, lambda;         ///< kg, m^3, Pa
  T v[3], C[9];                       ///< m/s, 1/s
  T shear_viscosity, bulk_viscosity;  ///< Pa s
  T damping_rate;                     ///< 1/s; mass-proportional damping lets v decay with exp(-rate t)
  T stress_kind;                      ///< a StressKind
  T x_rest[3], F_rest[9];             ///< what rounding cut off from x and F
  uint32_t bits;                      ///< of the loads that act on it
  int32_t index;                      ///< in the order of the particles
  uint16_t material, object;
  int32_t side;  ///< place among the particles whose stress is given, or -1
};

// Offsets of the groups.
constexpr int kPlaceGroup = 0, kConstantGroup = 12, kVelocityGroup = 16, kDampingGroup = 28, kRestGroup = 32;
static_assert(sizeof(ParticleRecord<float>) == 192);

}  // namespace pliant
