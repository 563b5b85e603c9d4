#pragma once

#include "physics/mpm/kernels/gather_adjoint_kernels.h"
#include "physics/mpm/kernels/gather_kernels.h"
#include "physics/mpm/kernels/piola_adjoint_kernels.h"

// Transfers of Lagrangian runs in the reverse direction: weights are constants there, so that a scatter is the whole
// way back of a gather and a gather that of a scatter.

namespace pliant::PLIANT_ISA {

/// An affine field at the particles of a pack, ready for scatter_one: value at the particles, change along[axis][3] per
/// cell.
template <class T>
struct AffineField {
  alignas(64) T weight[12][kLanes];
  alignas(64) T value[kLanes][16];
  int corner[kLanes];
  Pack<T> offset[3];  // of the particles from their lowest nodes, cells

  INLINE void set_place(const Pack<T>* X, const T* origin, T inverse_dx) {
    const SplinePack<T> sx((X[0] - origin[0]) * inverse_dx), sy((X[1] - origin[1]) * inverse_dx),
        sz((X[2] - origin[2]) * inverse_dx);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) store(weight[3 * i + j], sx.weight[i] * sy.weight[j]);
      store(weight[9 + i], sz.weight[i]);
    }
    corners<T>(sx.base, sy.base, sz.base, corner);
    offset[0] = sx.offset;
    offset[1] = sy.offset;
    offset[2] = sz.offset;
  }
  INLINE void scatter(int lanes, const Pack<T>* at_particle, const Pack<T> (*along)[3], T* patch) {
    T* value_at[kLanes];
    for (int l = 0; l < kLanes; ++l) value_at[l] = value[l];
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b) {
      base[b] = at_particle[b];
      for (int a = 0; a < 3; ++a) base[b] -= along[a][b] * offset[a];
    }
    store_group<T>(value_at, 0, base[0], base[1], base[2], Pack<T>{});
    for (int a = 0; a < 3; ++a) store_group<T>(value_at, 4 + 4 * a, along[a][0], along[a][1], along[a][2], Pack<T>{});
    for (int l = 0; l < lanes; ++l) scatter_one<T>(value[l], weight, l, patch + corner[l]);
  }
};

/// v' = sum w v_i, C' = 4 / dx^2 sum w v_i (X_i - X)^T, F' = F + dt C', x' = x + dt v', backwards.
template <class T>
INLINE void reverse_gather_lagrangian(const AdjointRun<T>& run, T* patch) {
  AffineField<T> field;
  const T dt = run.dt, c_scale = 4 * run.inverse_dx;
  for (int first = 0; first < run.count; first += kLanes) {
    const T* tape[kLanes];
    T* at[kLanes];
    const int lanes = point_at(run, first, tape, at);
    Pack<T> by_place[12], by_motion[12], rest[4], X[4];
    for (int k = 0; k < 12; k += 4) {
      load_group<T>(at, kAdjointPlace + k, by_place + k);
      load_group<T>(at, kAdjointVelocity + k, by_motion + k);
    }
    load_group<T>(at, kAdjointRest, rest);
    const Mask<T> put_back = whole(rest[2]);
    if (__builtin_expect(lane_bits(put_back != 0) != 0, 0)) {
      for (int a = 0; a < 3; ++a) {
        const auto out = (put_back & (1 << a)) != 0;
        by_place[a] = out ? Pack<T>{} : by_place[a];
        by_motion[a] = out ? Pack<T>{} : by_motion[a];
      }
      store_group<T>(at, kAdjointPlace, by_place[0], by_place[1], by_place[2], by_place[3]);
    }
    stencil_place<T, true>(run, first, lanes, by_place, X);
    field.set_place(X, run.origin, run.inverse_dx);
    Pack<T> value[3], along[3][3];
    for (int b = 0; b < 3; ++b) {
      value[b] = fma(all<Pack<T>>(dt), by_place[b], by_motion[b]);
      for (int a = 0; a < 3; ++a)
        along[a][b] = c_scale * fma(all<Pack<T>>(dt), by_place[3 + 3 * b + a], by_motion[3 + 3 * b + a]);
    }
    field.scatter(lanes, value, along, patch);
  }
}

/// What the nodes of a pack's stencils say of an affine field that was scattered to them.
template <class T>
struct LagrangianSums {
  Pack<T> by_value[4], by_along[3][3];

  INLINE LagrangianSums(const StencilLanes<T>& stencil, int lanes, const T* nodes) {
    alignas(64) T out[kLanes][16];
    T* out_at[kLanes];
    for (int l = 0; l < kLanes; ++l) out_at[l] = out[l];
    for (int l = 0; l < lanes; ++l) gather_one<T>(nodes + stencil.corner[l], stencil.weight, l, out[l]);
    for (int l = lanes; l < kLanes; ++l) __builtin_memcpy(out[l], out[lanes - 1], sizeof out[l]);
    Pack<T> sums[16];
    for (int k = 0; k < 16; k += 4) load_group<T>(out_at, k, sums + k);
    for (int b = 0; b < 4; ++b) by_value[b] = sums[b];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) by_along[a][b] = sums[4 + 4 * a + b] - stencil.from_middle[a] * sums[b];
  }
};

/// m_i = sum w m, and momenta sum w (m (k g + (k - q) v) + (m (k - q) C - dt 4 / dx^2 V P) (X_i - X)), g what loads
/// give, k what damping keeps and q 0 for whole momenta and 1 for their change, and dt w s (u + G (X_i - X)), s the
/// stabilization, u and G of the displacement, backwards.
template <class T, Mixture kMixture>
INLINE void reverse_scatter_lagrangian(const AdjointRun<T>& run, StressKind kind, const T* nodes) {
  StencilLanes<T> stencil;
  const T stress_scale = -run.dt * 4 * run.inverse_dx, change = run.whole ? T(0) : T(1);
  for (int first = 0; first < run.count; first += kLanes) {
    const T* tape[kLanes];
    T* at[kLanes];
    const int lanes = point_at(run, first, tape, at);
    Pack<T> place[12], motion[12], constant[4], damping[4], X[4];
    for (int k = 0; k < 12; k += 4) {
      load_group<T>(tape, kTapePlace + k, place + k);
      load_group<T>(tape, kTapeVelocity + k, motion + k);
    }
    load_group<T>(at, kAdjointConstant, constant);
    if (kMixture == Mixture::kAny) load_group<T>(at, kAdjointDamping, damping);
    const Pack<T>*F = place + 3, *v = motion, *C = motion + 3;
    const Pack<T> mass = constant[0], mu = constant[2], lambda = constant[3];
    stencil_place<T, true>(run, first, lanes, place, X);
    stencil.set(X, run.origin, run.inverse_dx);
    // Velocity with what loads gave.
    Pack<T> kept = all<Pack<T>>(T(1)), loaded_v[3] = {v[0], v[1], v[2]};
    if constexpr (kMixture == Mixture::kAny) kept = exponential(-run.dt * damping[2]);
    if (run.loaded_v)
      for (int l = 0; l < kLanes; ++l)
        for (int a = 0; a < 3; ++a) loaded_v[a][l] = run.loaded_v[3 * (first + (l < lanes ? l : lanes - 1)) + a];
    const Pack<T> s = stress_scale * constant[1], carried = mass * (kept - change), m = carried * run.dx;
    const LagrangianSums<T> sums(stencil, lanes, nodes);
    // Derivatives by what is kept and by the mass: momentum / mass = k (v + g) - q v + (k - q) C d.
    Pack<T> by_loaded{}, by_own{}, by_along{};
    for (int b = 0; b < 3; ++b) {
      by_loaded = fma(loaded_v[b], sums.by_value[b], by_loaded);
      by_own = fma(v[b], sums.by_value[b], by_own);
      for (int a = 0; a < 3; ++a) by_along = fma(C[3 * b + a], sums.by_along[a][b], by_along);
    }
    by_along *= run.dx;
    const Pack<T> by_kept = by_loaded + by_along;
    const Pack<T> by_mass = fma(kept, by_kept, sums.by_value[3]) - change * (by_own + by_along);
    Pack<T> by_gain[3], whole_v[3], by_C[9], A[9];
    for (int b = 0; b < 3; ++b) {
      whole_v[b] = mass * sums.by_value[b];
      by_gain[b] = run.loaded_v ? kept * whole_v[b] : carried * sums.by_value[b];
      for (int a = 0; a < 3; ++a) {
        by_C[3 * b + a] = m * sums.by_along[a][b];
        A[3 * b + a] = s * sums.by_along[a][b];
      }
    }

    // The particle's part of the stabilization, whose stiffness is so much of mu.
    const T* undisplaced[kLanes];
    for (int l = 0; l < kLanes; ++l) undisplaced[l] = run.undisplaced + 12 * (first + (l < lanes ? l : lanes - 1));
    Pack<T> before[12], by_affine[9], by_stiffness{};
    for (int k = 0; k < 12; k += 4) load_group<T>(undisplaced, k, before + k);
    const Pack<T> stiffness = run.dt * X[3], per_cell = stiffness * run.dx;
    for (int b = 0; b < 3; ++b) {
      by_stiffness = fma(sums.by_value[b], place[b] - before[b], by_stiffness);
      for (int a = 0; a < 3; ++a) {
        by_affine[3 * b + a] = per_cell * sums.by_along[a][b];
        by_stiffness = fma(run.dx * sums.by_along[a][b], F[3 * b + a] - before[3 + 3 * b + a], by_stiffness);
      }
    }

    StressAdjointPack<T> by;
    Pack<T> total[4], rest[4];
    load_group<T>(at, kAdjointSum, total);
    load_group<T>(at, kAdjointRest, rest);
    if constexpr (kMixture == Mixture::kUniform) {
      law_piola_adjoint<T>(run, kind, F, mu, lambda, A, by);
    } else {
      for (int k = 0; k < 9; ++k) by.F[k] = Pack<T>{};
      by.mu = by.lambda = Pack<T>{};
      const StressKind laws[2] = {StressKind::kFixedCorotated, StressKind::kNeoHookean};
      for (const StressKind law : laws) {
        const auto mine = damping[3] == all<Pack<T>>(static_cast<T>(static_cast<int>(law)));
        if (lane_bits(mine) == 0) continue;
        Pack<T> shaped[9];
        StressAdjointPack<T> part;
        for (int k = 0; k < 9; ++k) shaped[k] = mine ? F[k] : all<Pack<T>>(T(k % 4 == 0));
        law_piola_adjoint<T>(run, law, shaped, mu, lambda, A, part);
        for (int k = 0; k < 9; ++k) by.F[k] = mine ? part.F[k] : by.F[k];
        by.mu = mine ? part.mu : by.mu;
        by.lambda = mine ? part.lambda : by.lambda;
      }
      const Pack<T> viscous = all<Pack<T>>(run.viscosity_time);
      const ViscosityAdjointPack<T> by_viscosity =
          viscous_piola_adjoint<T>(F, C, fma(viscous, mu, damping[0]), fma(viscous, lambda, damping[1]), A, by.F, by_C);
      const Pack<T> time = run.viscosity_time + rest[1];
      by.mu = fma(by_viscosity.shear, time, by.mu);
      by.lambda = fma(by_viscosity.bulk, time, by.lambda);
      total[3] += fma(by_viscosity.shear, mu, by_viscosity.bulk * lambda);
      rest[0] -= run.dt * mass * kept * by_kept;
    }
    total[0] += by_mass;
    total[1] += fma(by_stiffness, stiffness / mu, by.mu);
    total[2] += by.lambda;
    rest[2] = Pack<T>{};
    for (int a = 0; a < 3; ++a) {
      const auto out_of = (place[a] == all<Pack<T>>(run.low[a])) | (place[a] == all<Pack<T>>(run.high[a]));
      rest[2] += where(out_of, all<Pack<T>>(T(1 << a)));
    }

    Pack<T> by_place[12];
    for (int k = 0; k < 12; k += 4) load_group<T>(at, kAdjointPlace + k, by_place + k);
    for (int b = 0; b < 3; ++b) by_place[b] = fma(stiffness, sums.by_value[b], by_place[b]);
    for (int k = 0; k < 9; ++k) by_place[3 + k] += by.F[k] + by_affine[k];
    for (int k = 0; k < 12; k += 4)
      store_group<T>(at, kAdjointPlace + k, by_place[k], by_place[k + 1], by_place[k + 2], by_place[k + 3]);
    // With loads: by what they gave, from which the derivative by v follows once those by the loads are found.
    if (run.loaded_v) store_group<T>(at, kAdjointAfter, whole_v[0], whole_v[1], whole_v[2], Pack<T>{});
    store_group<T>(at, kAdjointVelocity, by_gain[0], by_gain[1], by_gain[2], by_C[0]);
    store_group<T>(at, kAdjointVelocity + 4, by_C[1], by_C[2], by_C[3], by_C[4]);
    store_group<T>(at, kAdjointVelocity + 8, by_C[5], by_C[6], by_C[7], by_C[8]);
    store_group<T>(at, kAdjointSum, total[0], total[1], total[2], total[3]);
    store_group<T>(at, kAdjointRest, rest[0], rest[1], rest[2], rest[3]);
  }
}

}  // namespace pliant::PLIANT_ISA
