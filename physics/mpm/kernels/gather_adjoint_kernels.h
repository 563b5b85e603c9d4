#pragma once

#include "physics/mpm/kernels/step_adjoint_view.h"
#include "physics/mpm/kernels/transfer_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

/// Records of up to a pack's worth of particles, and what the tape says of them; spare lanes repeat the last one.
template <class T>
INLINE int point_at(const AdjointRun<T>& run, int first, const T** tape, T** record) {
  const int left = run.count - first, lanes = left < kLanes ? left : kLanes;
  for (int l = 0; l < kLanes; ++l) {
    const int s = first + (l < lanes ? l : lanes - 1);
    tape[l] = reinterpret_cast<const T*>(run.particle + s);
    record[l] = reinterpret_cast<T*>(run.record + run.slot[run.index[s]]);
  }
  constexpr int kAhead = 2 * kLanes;
  if (first + kAhead + kLanes <= run.count)
    for (int l = 0; l < kLanes; ++l) {
      const char* r = reinterpret_cast<const char*>(run.record + run.slot[run.index[first + kAhead + l]]);
      for (unsigned k = 0; k < sizeof(AdjointRecord<T>); k += 64) __builtin_prefetch(r + k);
    }
  return lanes;
}

/// Of the grid: V = sum w v_i, A = 4 / dx^2 sum w v_i (x_i - x)^T, and V_old, A_old of the velocities before the step.
/// v' = V + flip (v - V_old), C' = A + flip (C - A_old), F' = (I + dt A) F, x' = x + dt V, backwards; `C_after` holds
/// A. What v and C get directly is left in the place of the derivatives by v' and C'.
template <class T, bool kFlip>
INLINE void reverse_gather_run(const AdjointRun<T>& run, const T* velocity, T* patch, const T* old_velocity,
                               T* old_patch) {
  StencilLanes<T> stencil;
  alignas(64) T value[kLanes][16], slopes[kLanes][12];
  T *value_at[kLanes], *slopes_at[kLanes];
  for (int l = 0; l < kLanes; ++l) {
    value_at[l] = value[l];
    slopes_at[l] = slopes[l];
  }
  const T dt = run.dt, c_scale = 4 * run.inverse_dx;
  for (int first = 0; first < run.count; first += kLanes) {
    const T* tape[kLanes];
    T* at[kLanes];
    const int lanes = point_at(run, first, tape, at);
    Pack<T> place[12], by_place[12], by_motion[12], after[12], rest[4];
    for (int k = 0; k < 12; k += 4) {
      load_group<T>(tape, kTapePlace + k, place + k);
      load_group<T>(at, kAdjointPlace + k, by_place + k);
      load_group<T>(at, kAdjointVelocity + k, by_motion + k);
      load_group<T>(at, kAdjointAfter + k, after + k);
    }
    load_group<T>(at, kAdjointRest, rest);
    const Mask<T> put_back = whole(rest[2]);
    const uint32_t any_put_back = lane_bits(put_back != 0);
    if (__builtin_expect(any_put_back != 0, 0))
      for (int a = 0; a < 3; ++a) {
        const auto out = (put_back & (1 << a)) != 0;
        by_place[a] = out ? Pack<T>{} : by_place[a];
        by_motion[a] = out ? Pack<T>{} : by_motion[a];
      }
    stencil.set(place, run.origin, run.inverse_dx);

    const Pack<T>*F = place + 3, *C = after + 3;
    Pack<T>*by_F = by_place + 3, *by_C = by_motion + 3;
    Pack<T> g[3], G[9], new_F[9], by_grid_C[9];
    for (int k = 0; k < 9; ++k) by_grid_C[k] = by_C[k];
    if (run.by_grid_C)
      for (int l = 0; l < kLanes; ++l)
        for (int k = 0; k < 9; ++k) by_grid_C[k][l] += run.by_grid_C[9 * (first + (l < lanes ? l : lanes - 1)) + k];
    for (int a = 0; a < 3; ++a) {
      g[a] = fma(all<Pack<T>>(dt), by_place[a], by_motion[a]);
      for (int c = 0; c < 3; ++c) {
        const Pack<T> FF =
            fma(by_F[3 * a + 2], F[3 * c + 2], fma(by_F[3 * a + 1], F[3 * c + 1], by_F[3 * a] * F[3 * c]));
        G[3 * a + c] = c_scale * fma(all<Pack<T>>(dt), FF, by_grid_C[3 * a + c]);
        const Pack<T> CF = fma(C[6 + a], by_F[6 + c], fma(C[3 + a], by_F[3 + c], C[a] * by_F[c]));
        new_F[3 * a + c] = fma(all<Pack<T>>(dt), CF, by_F[3 * a + c]);
      }
    }
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b) {
      base[b] = g[b];
      for (int a = 0; a < 3; ++a) base[b] -= G[3 * b + a] * (stencil.from_middle[a] + T(1));
    }
    store_group<T>(value_at, 0, base[0], base[1], base[2], Pack<T>{});
    for (int a = 0; a < 3; ++a) store_group<T>(value_at, 4 + 4 * a, G[a], G[3 + a], G[6 + a], Pack<T>{});
    for (int l = 0; l < lanes; ++l)
      scatter_with_slopes<T>(stencil, l, value[l], velocity + stencil.corner[l], patch + stencil.corner[l], slopes[l]);
    for (int l = lanes; l < kLanes; ++l) __builtin_memcpy(slopes[l], slopes[lanes - 1], sizeof slopes[l]);
    Pack<T> sums[12];
    for (int k = 0; k < 12; k += 4) load_group<T>(slopes_at, k, sums + k);
    // V: of APIC particles it is v', unless they were put back.
    for (uint32_t bits = kFlip ? (1u << kLanes) - 1 : any_put_back; bits != 0; bits &= bits - 1) {
      const int l = __builtin_ctz(bits);
      const OneNode<T> v = value_at_particle<T>(stencil, l, velocity + stencil.corner[l]);
      for (int a = 0; a < 3; ++a) after[a][l] = v[a];
    }
    for (int a = 0; a < 3; ++a) {
      const Pack<T> slope = (sums[4 * a] + sums[4 * a + 1]) + (sums[4 * a + 2] + sums[4 * a + 3]);
      const Pack<T> moved = fma(G[6 + a], after[2], fma(G[3 + a], after[1], G[a] * after[0]));
      by_place[a] = fma(all<Pack<T>>(run.inverse_dx), slope - moved, by_place[a]);
    }
    if constexpr (kFlip) {
      Pack<T> direct[12], along[3][3], old_v[3] = {};
      for (int k = 0; k < 12; ++k) direct[k] = run.flip * by_motion[k];
      for (int b = 0; b < 3; ++b) {
        base[b] = -direct[b];
        for (int a = 0; a < 3; ++a) {
          along[a][b] = -c_scale * direct[3 + 3 * b + a];
          base[b] -= along[a][b] * (stencil.from_middle[a] + T(1));
        }
      }
      store_group<T>(value_at, 0, base[0], base[1], base[2], Pack<T>{});
      for (int a = 0; a < 3; ++a) store_group<T>(value_at, 4 + 4 * a, along[a][0], along[a][1], along[a][2], Pack<T>{});
      for (int l = 0; l < lanes; ++l) {
        const OneNode<T> v = value_at_particle<T>(stencil, l, old_velocity + stencil.corner[l]);
        for (int a = 0; a < 3; ++a) old_v[a][l] = v[a];
        scatter_with_slopes<T>(stencil, l, value[l], old_velocity + stencil.corner[l], old_patch + stencil.corner[l],
                               slopes[l]);
      }
      for (int l = lanes; l < kLanes; ++l) {
        __builtin_memcpy(slopes[l], slopes[lanes - 1], sizeof slopes[l]);
        for (int a = 0; a < 3; ++a) old_v[a][l] = old_v[a][lanes - 1];
      }
      for (int a = 0; a < 3; ++a) {
        load_group<T>(slopes_at, 4 * a, sums);
        Pack<T> slope = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        for (int b = 0; b < 3; ++b) slope -= along[a][b] * old_v[b];
        by_place[a] = fma(all<Pack<T>>(run.inverse_dx), slope, by_place[a]);
      }
      for (int k = 0; k < 12; k += 4)
        store_group<T>(at, kAdjointVelocity + k, direct[k], direct[k + 1], direct[k + 2], direct[k + 3]);
    }
    store_group<T>(at, kAdjointPlace, by_place[0], by_place[1], by_place[2], new_F[0]);
    store_group<T>(at, kAdjointPlace + 4, new_F[1], new_F[2], new_F[3], new_F[4]);
    store_group<T>(at, kAdjointPlace + 8, new_F[5], new_F[6], new_F[7], new_F[8]);
  }
}

}  // namespace pliant::PLIANT_ISA
