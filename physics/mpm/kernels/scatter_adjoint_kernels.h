#pragma once

#include "physics/mpm/kernels/gather_adjoint_kernels.h"
#include "physics/mpm/kernels/scatter_kernels.h"
#include "physics/mpm/kernels/stress_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

/// Stress of a pack of particles, forwards and backwards; `kind` if all are of one law, else by lane.
template <class T, Mixture kMixture>
struct StressPack {
  const AdjointRun<T>& run;
  StressKind kind;
  int first, lanes;
  const Pack<T>*F, &mu, &lambda, &kinds;
  Pack<T> R[9], shaped[2][9];  // F of each law, and the identity in the lanes of others
  uint32_t unsafe[2] = {}, present[2] = {};

  INLINE auto mine(StressKind law) const { return kinds == all<Pack<T>>(static_cast<T>(static_cast<int>(law))); }

  INLINE uint32_t evaluate_law(StressKind law, const Pack<T>* f, Pack<T>* tau) {
    if (law == StressKind::kNeoHookean) return neo_hookean<T>(f, mu, lambda, tau);
    Pack<T> J;
    const uint32_t bits = rotation<T>(f, R, J);
    fixed_corotated_of<T>(f, R, J, mu, lambda, tau);
    return bits;
  }

  INLINE void evaluate(Pack<T>* tau) {
    if constexpr (kMixture == Mixture::kUniform) {
      unsafe[0] = evaluate_law(kind, F, tau);
      if (__builtin_expect(unsafe[0] != 0, 0)) repair_stress<T>(unsafe[0], kind, F, mu, lambda, run.exact_stress, tau);
      return;
    }
    for (int k = 0; k < 6; ++k) tau[k] = Pack<T>{};
    for (int law = 0; law < 2; ++law) {
      const auto lane = mine(static_cast<StressKind>(law));
      present[law] = lane_bits(lane);
      if (present[law] == 0) continue;
      Pack<T> part[6];
      for (int k = 0; k < 9; ++k) shaped[law][k] = lane ? F[k] : all<Pack<T>>(T(k % 4 == 0));
      unsafe[law] = evaluate_law(static_cast<StressKind>(law), shaped[law], part);
      if (unsafe[law] != 0)
        repair_stress<T>(unsafe[law], static_cast<StressKind>(law), shaped[law], mu, lambda, run.exact_stress, part);
      for (int k = 0; k < 6; ++k) tau[k] = lane ? part[k] : tau[k];
    }
    for (int l = 0; l < kLanes; ++l) {
      if ((present[0] | present[1]) >> l & 1) continue;
      const T* stress = run.given_stress + 6 * (first + (l < lanes ? l : lanes - 1));
      for (int k = 0; k < 6; ++k) tau[k][l] = stress[k];
    }
  }

  INLINE void reverse_law(StressKind law, uint32_t unsafe_lanes, const Pack<T>* f, const Pack<T>* S,
                          StressAdjointPack<T>& by) const {
    unsafe_lanes |= law == StressKind::kNeoHookean ? neo_hookean_adjoint<T>(f, mu, lambda, S, by)
                                                   : fixed_corotated_adjoint<T>(f, R, mu, lambda, S, by);
    for (uint32_t bits = unsafe_lanes; __builtin_expect(bits != 0, 0); bits &= bits - 1) {
      const int l = __builtin_ctz(bits);
      T one_F[9], one_S[6], by_F[9], by_lame[2];
      for (int k = 0; k < 9; ++k) one_F[k] = f[k][l];
      for (int k = 0; k < 6; ++k) one_S[k] = S[k][l];
      run.exact_adjoint(law, one_F, mu[l], lambda[l], one_S, by_F, by_lame);
      for (int k = 0; k < 9; ++k) by.F[k][l] = by_F[k];
      by.mu[l] = by_lame[0];
      by.lambda[l] = by_lame[1];
    }
  }

  INLINE void reverse(const Pack<T>* S, StressAdjointPack<T>& by) const {
    if constexpr (kMixture == Mixture::kUniform) {
      reverse_law(kind, unsafe[0], F, S, by);
      return;
    }
    for (int k = 0; k < 9; ++k) by.F[k] = Pack<T>{};
    by.mu = by.lambda = Pack<T>{};
    for (int law = 0; law < 2; ++law) {
      if (present[law] == 0) continue;
      StressAdjointPack<T> part;
      reverse_law(static_cast<StressKind>(law), unsafe[law], shaped[law], S, part);
      const auto lane = mine(static_cast<StressKind>(law));
      for (int k = 0; k < 9; ++k) by.F[k] = lane ? part.F[k] : by.F[k];
      by.mu = lane ? part.mu : by.mu;
      by.lambda = lane ? part.lambda : by.lambda;
    }
    for (int l = 0; l < lanes; ++l) {
      if ((present[0] | present[1]) >> l & 1) continue;
      for (int k = 0; k < 6; ++k) run.by_given_stress[6 * (first + l) + k] = S[k][l];
    }
  }
};

/// What the nodes of a pack's stencils say of an affine field that was scattered to them: value[4] at the particles
/// and its change along[axis][3] per cell.
template <class T>
struct ScatterSums {
  Pack<T> by_value[4], by_along[3][3], by_x[3];  ///< derivatives; by_x in 1 / cell

  INLINE ScatterSums(const StencilLanes<T>& stencil, int lanes, const Pack<T>* value, const Pack<T> (*along)[3],
                     const T* nodes) {
    alignas(64) T affine[kLanes][16], out[kLanes][28];
    T *affine_at[kLanes], *out_at[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      affine_at[l] = affine[l];
      out_at[l] = out[l];
    }
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b) {
      base[b] = value[b];
      for (int a = 0; a < 3; ++a) base[b] -= along[a][b] * (stencil.from_middle[a] + T(1));
    }
    store_group<T>(affine_at, 0, base[0], base[1], base[2], value[3]);
    for (int a = 0; a < 3; ++a) store_group<T>(affine_at, 4 + 4 * a, along[a][0], along[a][1], along[a][2], Pack<T>{});
    for (int l = 0; l < lanes; ++l) gather_with_slopes<T>(stencil, l, affine[l], nodes + stencil.corner[l], out[l]);
    for (int l = lanes; l < kLanes; ++l) __builtin_memcpy(out[l], out[lanes - 1], sizeof out[l]);
    Pack<T> sums[28];
    for (int k = 0; k < 28; k += 4) load_group<T>(out_at, k, sums + k);
    for (int b = 0; b < 4; ++b) by_value[b] = sums[b];
    for (int a = 0; a < 3; ++a) {
      by_x[a] = (sums[16 + 4 * a] + sums[17 + 4 * a]) + (sums[18 + 4 * a] + sums[19 + 4 * a]);
      for (int b = 0; b < 3; ++b) {
        by_along[a][b] = sums[4 + 4 * a + b] - stencil.from_middle[a] * sums[b];
        by_x[a] -= along[a][b] * sums[b];
      }
    }
  }
};

/// m_i = sum w m, (m v)_i = sum w (m v + (m C - dt 4 / dx^2 V tau) (x_i - x)), backwards.
template <class T, Mixture kMixture>
INLINE void reverse_scatter_run(const AdjointRun<T>& run, StressKind kind, const T* nodes, const T* old_nodes) {
  StencilLanes<T> stencil;
  const T stress_scale = -run.dt * 4 * run.inverse_dx;
  for (int first = 0; first < run.count; first += kLanes) {
    const T* tape[kLanes];
    T* at[kLanes];
    const int lanes = point_at(run, first, tape, at);
    Pack<T> place[12], motion[12], constant[4], damping[4];
    for (int k = 0; k < 12; k += 4) {
      load_group<T>(tape, kTapePlace + k, place + k);
      load_group<T>(tape, kTapeVelocity + k, motion + k);
    }
    load_group<T>(at, kAdjointConstant, constant);
    if (kMixture == Mixture::kAny) load_group<T>(at, kAdjointDamping, damping);
    const Pack<T>*F = place + 3, *v = motion, *C = motion + 3, mass = constant[0], mu = constant[2],
          *lambda = constant + 3;

    // What was scattered, as in `scatter_particles`.
    StressPack<T, kMixture> stress{run, kind, first, lanes, F, constant[2], constant[3], damping[3], {}, {}};
    Pack<T> tau[6], shear{}, bulk{};
    stress.evaluate(tau);
    const Pack<T> C_trace = C[0] + C[4] + C[8];
    Pack<T> kept = all<Pack<T>>(T(1)), loaded_v[3] = {v[0], v[1], v[2]};
    if constexpr (kMixture == Mixture::kAny) {
      const Pack<T> time = all<Pack<T>>(run.viscosity_time);
      shear = fma(time, mu, damping[0]);
      bulk = fma(time, *lambda, damping[1]);
      for (int i = 0; i < 3; ++i) tau[i] += fma(shear + shear, C[4 * i], bulk * C_trace);
      tau[3] += shear * (C[5] + C[7]);
      tau[4] += shear * (C[2] + C[6]);
      tau[5] += shear * (C[1] + C[3]);
      kept = exponential(-run.dt * damping[2]);
    }
    if (run.loaded_v)
      for (int l = 0; l < kLanes; ++l)
        for (int a = 0; a < 3; ++a) loaded_v[a][l] = run.loaded_v[3 * (first + (l < lanes ? l : lanes - 1)) + a];
    const Pack<T> s = stress_scale * constant[1], m = mass * run.dx * kept, carried = mass * kept;
    const int symmetric[9] = {0, 5, 4, 5, 1, 3, 4, 3, 2};
    Pack<T> along[3][3];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) along[a][b] = fma(m, C[3 * b + a], s * tau[symmetric[3 * a + b]]);
    stencil.set(place, run.origin, run.inverse_dx);
    const Pack<T> value[4] = {carried * loaded_v[0], carried * loaded_v[1], carried * loaded_v[2], mass};
    ScatterSums<T> sums(stencil, lanes, value, along, nodes);
    Pack<T> S[6];
    for (int i = 0; i < 3; ++i) S[i] = s * sums.by_along[i][i];
    const Pack<T> half = T(0.5) * s;
    S[3] = half * (sums.by_along[1][2] + sums.by_along[2][1]);
    S[4] = half * (sums.by_along[0][2] + sums.by_along[2][0]);
    S[5] = half * (sums.by_along[0][1] + sums.by_along[1][0]);
    // Derivative by the factor of v and C, over that factor.
    const auto by_factor = [&](const ScatterSums<T>& of) {
      Pack<T> by_value{}, by_along{};
      for (int b = 0; b < 3; ++b) {
        by_value = fma(loaded_v[b], of.by_value[b], by_value);
        for (int a = 0; a < 3; ++a) by_along = fma(C[3 * b + a], of.by_along[a][b], by_along);
      }
      return fma(all<Pack<T>>(run.dx), by_along, by_value);
    };
    const Pack<T> by_kept = by_factor(sums);
    Pack<T> by_mass = fma(kept, by_kept, sums.by_value[3]), by_loaded_v[3], by_C[9];
    for (int b = 0; b < 3; ++b) {
      by_loaded_v[b] = carried * sums.by_value[b];
      for (int a = 0; a < 3; ++a) by_C[3 * b + a] = m * sums.by_along[a][b];
    }
    if (run.flip > T(0)) {
      // The velocities before the step come from the same scatter without stress and damping.
      const Pack<T> old_m = mass * run.dx,
                    old_value[4] = {mass * loaded_v[0], mass * loaded_v[1], mass * loaded_v[2], mass};
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) along[a][b] = old_m * C[3 * b + a];
      const ScatterSums<T> old(stencil, lanes, old_value, along, old_nodes);
      by_mass += by_factor(old) + old.by_value[3];
      Pack<T> direct[12];  // by the loaded velocity and by C themselves
      for (int k = 0; k < 12; k += 4) load_group<T>(at, kAdjointVelocity + k, direct + k);
      for (int b = 0; b < 3; ++b) {
        sums.by_x[b] += old.by_x[b];
        by_loaded_v[b] += fma(mass, old.by_value[b], direct[b]);
        for (int a = 0; a < 3; ++a) by_C[3 * b + a] += fma(old_m, old.by_along[a][b], direct[3 + 3 * b + a]);
      }
    }
    StressAdjointPack<T> by;
    stress.reverse(S, by);

    Pack<T> total[4], rest[4];
    load_group<T>(at, kAdjointSum, total);
    load_group<T>(at, kAdjointRest, rest);
    if constexpr (kMixture == Mixture::kAny) {
      const Pack<T> S_trace = S[0] + S[1] + S[2], by_bulk = S_trace * C_trace;
      Pack<T> by_shear = S[3] * (C[5] + C[7]) + S[4] * (C[2] + C[6]) + S[5] * (C[1] + C[3]);
      for (int i = 0; i < 3; ++i) by_shear = fma(S[i], C[4 * i], by_shear);
      by_shear += by_shear;
      for (int k = 0; k < 9; ++k) by_C[k] = fma(shear + shear, S[symmetric[k]], by_C[k]);
      for (int k = 0; k < 9; k += 4) by_C[k] = fma(bulk, S_trace, by_C[k]);
      const Pack<T> time = run.viscosity_time + rest[1];
      by.mu = fma(by_shear, time, by.mu);
      by.lambda = fma(by_bulk, time, by.lambda);
      total[3] += fma(by_shear, mu, by_bulk * *lambda);
      rest[0] -= run.dt * carried * by_kept;
    }
    total[0] += by_mass;
    total[1] += by.mu;
    total[2] += by.lambda;
    rest[2] = Pack<T>{};
    for (int a = 0; a < 3; ++a) {
      const auto out_of = (place[a] == all<Pack<T>>(run.low[a])) | (place[a] == all<Pack<T>>(run.high[a]));
      rest[2] += where(out_of, all<Pack<T>>(T(1 << a)));
    }

    Pack<T> by_place[12];
    for (int k = 0; k < 12; k += 4) load_group<T>(at, kAdjointPlace + k, by_place + k);
    for (int a = 0; a < 3; ++a) by_place[a] = fma(all<Pack<T>>(run.inverse_dx), sums.by_x[a], by_place[a]);
    for (int k = 0; k < 9; ++k) by_place[3 + k] += by.F[k];
    for (int k = 0; k < 12; k += 4) {
      store_group<T>(at, kAdjointPlace + k, by_place[k], by_place[k + 1], by_place[k + 2], by_place[k + 3]);
      store_group<T>(at, kAdjointAfter + k, motion[k], motion[k + 1], motion[k + 2], motion[k + 3]);
    }
    store_group<T>(at, kAdjointVelocity, by_loaded_v[0], by_loaded_v[1], by_loaded_v[2], by_C[0]);
    store_group<T>(at, kAdjointVelocity + 4, by_C[1], by_C[2], by_C[3], by_C[4]);
    store_group<T>(at, kAdjointVelocity + 8, by_C[5], by_C[6], by_C[7], by_C[8]);
    store_group<T>(at, kAdjointSum, total[0], total[1], total[2], total[3]);
    store_group<T>(at, kAdjointRest, rest[0], rest[1], rest[2], rest[3]);
  }
}

}  // namespace pliant::PLIANT_ISA
