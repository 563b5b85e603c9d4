#pragma once

#include "physics/mpm/kernels/stress_kernels.h"

namespace pliant::PLIANT_ISA {

/// One elastic law without damping or viscosity, or anything.
enum class Mixture { kUniform, kAny };

/// Kirchhoff stress of the pack, viscosity included.
template <class T, Mixture kMixture>
INLINE void total_stress(const ScatterInput<T>& in, StressKind kind, const T* const* at, const Pack<T>* F,
                         const Pack<T>* C, Pack<T> mu, Pack<T> lambda, const Pack<T>* damping, Pack<T>* tau) {
  if constexpr (kMixture == Mixture::kUniform) {
    pack_stress<T>(kind, F, mu, lambda, in.exact_stress, tau);
    return;
  }
  // Each law that occurs in the pack, then lane by lane the one that applies.
  const Pack<T> kinds = damping[3];
  for (int k = 0; k < 6; ++k) tau[k] = Pack<T>{};
  const StressKind laws[2] = {StressKind::kFixedCorotated, StressKind::kNeoHookean};
  for (const StressKind one : laws) {
    const auto mine = kinds == all<Pack<T>>(static_cast<T>(static_cast<int>(one)));
    if (lane_bits(mine) == 0) continue;
    Pack<T> shaped[9], part[6];
    for (int k = 0; k < 9; ++k) shaped[k] = mine ? F[k] : all<Pack<T>>(T(k % 4 == 0));
    pack_stress<T>(one, shaped, mu, lambda, in.exact_stress, part);
    for (int k = 0; k < 6; ++k) tau[k] = mine ? part[k] : tau[k];
  }
  const uint32_t given = lane_bits(kinds == all<Pack<T>>(static_cast<T>(static_cast<int>(StressKind::kGiven))));
  for (int l = 0; l < kLanes; ++l) {
    if ((given >> l & 1) == 0) continue;
    const T* stress = in.given_stress + 6 * reinterpret_cast<const ParticleRecord<T>*>(at[l])->side;
    for (int k = 0; k < 6; ++k) tau[k][l] = stress[k];
  }
  // Kelvin-Voigt: the linear law applied to the strain rate.
  const Pack<T> time = all<Pack<T>>(in.viscosity_time), shear = fma(time, mu, damping[0]);
  const Pack<T> pressure = fma(time, lambda, damping[1]) * (C[0] + C[4] + C[8]);
  for (int i = 0; i < 3; ++i) tau[i] += fma(shear + shear, C[4 * i], pressure);
  tau[3] += shear * (C[5] + C[7]);
  tau[4] += shear * (C[2] + C[6]);
  tau[5] += shear * (C[1] + C[3]);
}

/// Adds one particle: node (i, j, k) receives w_ij wz_k (base + i X + j Y + k Z).
template <class T>
INLINE void scatter_one(const T* value, const T (*weight)[kLanes], int lane, T* corner) {
  using One = OneNode<T>;
  using Two = TwoNodes<T>;
  const One base = load<One>(value), X = load<One>(value + 4), Y = load<One>(value + 8), Z = load<One>(value + 12);
  const One wz2 = all<One>(weight[11][lane]);
  const Two wz01 = join<T>(all<One>(weight[9][lane]), all<One>(weight[10][lane]));
  const Two x01 = join<T>(X, X) * wz01, y01 = join<T>(Y, Y) * wz01;
  const One x2 = X * wz2, y2 = Y * wz2;
  Two plane01 = join<T>(base, base + Z) * wz01;
  One plane2 = (base + (Z + Z)) * wz2;
  for (int i = 0; i < 3; ++i) {
    Two row01 = plane01;
    One row2 = plane2;
    for (int j = 0; j < 3; ++j) {
      T* node = corner + i * kPlane + j * kRow;
      const T w = weight[3 * i + j][lane];
      store(node, fma(all<Two>(w), row01, load<Two>(node)));
      store(node + 8, fma(all<One>(w), row2, load<One>(node + 8)));
      row01 += y01;
      row2 += y2;
    }
    plane01 += x01;
    plane2 += x2;
  }
}

template <class T, Mixture kMixture>
INLINE void scatter_particles(const ScatterInput<T>& in, StressKind kind, T* patch) {
  const ParticleRun<T>& run = in.run;
  __builtin_memset(patch, 0, sizeof(T) * 6 * kPlane);
  const T stress_scale = in.inertia_only ? T(0) : -in.dt * 4 * run.inverse_dx;  // times V tau, per cell of distance
  alignas(64) T weight[12][kLanes];                                             // of x times y, then of z
  alignas(64) T value[kLanes][16];
  T* value_at[kLanes];
  for (int l = 0; l < kLanes; ++l) value_at[l] = value[l];
  int corner[kLanes];
  for (int first = 0; first < run.count; first += kLanes) {
    prefetch(run, first, 2);
    T* at[kLanes];
    const int lanes = point_at(run, first, at);
    Pack<T> place[12], constant[4], motion[12], damping[4];
    for (int k = 0; k < 12; k += 4) load_group<T>(at, kPlaceGroup + k, place + k);
    load_group<T>(at, kConstantGroup, constant);
    for (int k = 0; k < 12; k += 4) load_group<T>(at, kVelocityGroup + k, motion + k);
    if (kMixture == Mixture::kAny) load_group<T>(at, kDampingGroup, damping);
    const Pack<T>*F = place + 3, mass = constant[0], volume = constant[1];
    Pack<T>*v = motion, *C = motion + 3;

    const int symmetric[9] = {0, 5, 4, 5, 1, 3, 4, 3, 2};
    Pack<T> tau[6];
    total_stress<T, kMixture>(in, kind, at, F, C, constant[2], constant[3], damping, tau);
    const Pack<T> s = stress_scale * volume;
    Pack<T> kept = all<Pack<T>>(T(1));
    if (kMixture == Mixture::kAny && !in.inertia_only) kept = exponential(-in.dt * damping[2]);
    const Pack<T> carried = mass * kept, m = mass * run.dx * kept;
    Pack<T> along[3][3];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) along[a][b] = fma(m, C[3 * b + a], s * tau[symmetric[3 * b + a]]);

    const SplinePack<T> sx((place[0] - run.origin[0]) * run.inverse_dx),
        sy((place[1] - run.origin[1]) * run.inverse_dx), sz((place[2] - run.origin[2]) * run.inverse_dx);
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b)
      base[b] = carried * v[b] - along[0][b] * sx.offset - along[1][b] * sy.offset - along[2][b] * sz.offset;
    store_group<T>(value_at, 0, base[0], base[1], base[2], mass);
    for (int a = 0; a < 3; ++a) store_group<T>(value_at, 4 + 4 * a, along[a][0], along[a][1], along[a][2], Pack<T>{});
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) store(weight[3 * i + j], sx.weight[i] * sy.weight[j]);
      store(weight[9 + i], sz.weight[i]);
    }
    corners<T>(sx.base, sy.base, sz.base, corner);
    for (int l = 0; l < lanes; ++l) scatter_one<T>(value[l], weight, l, patch + corner[l]);
  }
}

template <class T>
void scatter_fixed_corotated(const ScatterInput<T>& in, T* patch) {
  scatter_particles<T, Mixture::kUniform>(in, StressKind::kFixedCorotated, patch);
}
template <class T>
void scatter_neo_hookean(const ScatterInput<T>& in, T* patch) {
  scatter_particles<T, Mixture::kUniform>(in, StressKind::kNeoHookean, patch);
}
template <class T>
void scatter_any(const ScatterInput<T>& in, T* patch) {
  scatter_particles<T, Mixture::kAny>(in, StressKind::kGiven, patch);
}

}  // namespace pliant::PLIANT_ISA
