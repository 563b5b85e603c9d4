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

/// First Piola-Kirchhoff stress of the pack in a Lagrangian run, viscosity included; `dF` is the rate of F.
template <class T, Mixture kMixture>
INLINE void total_piola(const ScatterInput<T>& in, StressKind kind, const Pack<T>* F, const Pack<T>* dF, Pack<T> mu,
                        Pack<T> lambda, const Pack<T>* damping, Pack<T>* P) {
  if constexpr (kMixture == Mixture::kUniform) {
    pack_piola<T>(kind, F, mu, lambda, in.exact_piola, P);
    return;
  }
  for (int k = 0; k < 9; ++k) P[k] = Pack<T>{};
  const StressKind laws[2] = {StressKind::kFixedCorotated, StressKind::kNeoHookean};
  for (const StressKind one : laws) {
    const auto mine = damping[3] == all<Pack<T>>(static_cast<T>(static_cast<int>(one)));
    if (lane_bits(mine) == 0) continue;
    Pack<T> shaped[9], part[9];
    for (int k = 0; k < 9; ++k) shaped[k] = mine ? F[k] : all<Pack<T>>(T(k % 4 == 0));
    pack_piola<T>(one, shaped, mu, lambda, in.exact_piola, part);
    for (int k = 0; k < 9; ++k) P[k] = mine ? part[k] : P[k];
  }
  // Kelvin-Voigt: the linear law applied to the strain rate L = dF F^-1, taken back by F^-T.
  Pack<T> inverse[9], L[9], tau[9], viscous[9];
  safe_inverse<T>(F, inverse);
  multiply<false, false, T>(dF, inverse, L);
  const Pack<T> time = all<Pack<T>>(in.viscosity_time), shear = fma(time, mu, damping[0]);
  const Pack<T> pressure = fma(time, lambda, damping[1]) * (L[0] + L[4] + L[8]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) tau[3 * i + j] = shear * (L[3 * i + j] + L[3 * j + i]);
  for (int k = 0; k < 9; k += 4) tau[k] += pressure;
  multiply<false, true, T>(tau, inverse, viscous);
  for (int k = 0; k < 9; ++k) P[k] += viscous[k];
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

template <class T, Mixture kMixture, bool kLagrangian>
INLINE void scatter_run(const ScatterInput<T>& in, StressKind kind, T* patch) {
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

    Pack<T> stress[9];
    if constexpr (kLagrangian) {
      total_piola<T, kMixture>(in, kind, F, C, constant[2], constant[3], damping, stress);
    } else {
      const int symmetric[9] = {0, 5, 4, 5, 1, 3, 4, 3, 2};
      Pack<T> tau[6];
      total_stress<T, kMixture>(in, kind, at, F, C, constant[2], constant[3], damping, tau);
      for (int k = 0; k < 9; ++k) stress[k] = tau[symmetric[k]];
    }
    const Pack<T> s = stress_scale * volume;
    Pack<T> kept = all<Pack<T>>(T(1));
    if (kMixture == Mixture::kAny && !in.inertia_only) kept = exponential(-in.dt * damping[2]);
    const Pack<T> share = kLagrangian && !in.whole ? kept - T(1) : kept;
    const Pack<T> carried = mass * share, m = mass * run.dx * share;
    Pack<T> along[3][3], X[4];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) along[a][b] = fma(m, C[3 * b + a], s * stress[3 * b + a]);

    stencil_place<T, kLagrangian>(run, first, lanes, place, X);
    const SplinePack<T> sx((X[0] - run.origin[0]) * run.inverse_dx), sy((X[1] - run.origin[1]) * run.inverse_dx),
        sz((X[2] - run.origin[2]) * run.inverse_dx);
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b) base[b] = carried * v[b];
    if constexpr (kLagrangian) {
      // The particle's part of the stabilization.
      const T* undisplaced[kLanes];
      for (int l = 0; l < kLanes; ++l) undisplaced[l] = run.undisplaced + 12 * (first + (l < lanes ? l : lanes - 1));
      Pack<T> before[12];
      for (int k = 0; k < 12; k += 4) load_group<T>(undisplaced, k, before + k);
      const Pack<T> stiffness = in.dt * X[3], per_cell = stiffness * run.dx;
      for (int b = 0; b < 3; ++b) {
        base[b] += stiffness * (place[b] - before[b]);
        for (int a = 0; a < 3; ++a) along[a][b] += per_cell * (F[3 * b + a] - before[3 + 3 * b + a]);
      }
    }
    for (int b = 0; b < 3; ++b)
      base[b] = base[b] - along[0][b] * sx.offset - along[1][b] * sy.offset - along[2][b] * sz.offset;
    if (kLagrangian && in.gain)
      for (int l = 0; l < lanes; ++l)
        for (int b = 0; b < 3; ++b) base[b][l] += mass[l] * kept[l] * in.gain[3 * (first + l) + b];
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

template <class T, Mixture kMixture>
INLINE void scatter_particles(const ScatterInput<T>& in, StressKind kind, T* patch) {
  if (in.run.rest_place)
    scatter_run<T, kMixture, true>(in, kind, patch);
  else
    scatter_run<T, kMixture, false>(in, kind, patch);
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
