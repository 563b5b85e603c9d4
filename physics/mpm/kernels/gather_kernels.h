#pragma once

#include "physics/mpm/kernels/node_kernels.h"

namespace pliant::PLIANT_ISA {

/// sum += increment without losing what is below the last digit of sum (Kahan 1965): a slow strain of many small
/// substeps would otherwise stand still in single precision, and the body would creep.
template <class V>
INLINE void accumulate(V& sum, V& rest, V increment) {
  const V whole = increment + rest, next = sum + whole;
  rest = whole - (next - sum);
  sum = next;
}

/// Moments of the node velocities about the middle stencil node, (1, 1, 1): v = sum w v_i to `out`, then
/// sum w (i - 1) v_i, sum w (j - 1) v_i and sum w (k - 1) v_i.  weight: three each along x, y, z.
template <class T>
INLINE void gather_one(const T* corner, const T (*weight)[kLanes], int lane, T* out) {
  using One = OneNode<T>;
  using Two = TwoNodes<T>;
  // Rows along z stay apart until the end; sums over y, then over x.
  Two v01[3], y01[3];
  One v2[3], y2[3];
  const T wy0 = weight[3][lane], wy1 = weight[4][lane], wy2 = weight[5][lane];
  for (int i = 0; i < 3; ++i) {
    const T* node = corner + i * kPlane;
    const Two a = load<Two>(node) * wy0, b = load<Two>(node + 2 * kRow) * wy2;
    v01[i] = fma(load<Two>(node + kRow), all<Two>(wy1), a + b);
    y01[i] = b - a;
    const One c = load<One>(node + 8) * wy0, d = load<One>(node + 2 * kRow + 8) * wy2;
    v2[i] = fma(load<One>(node + kRow + 8), all<One>(wy1), c + d);
    y2[i] = d - c;
  }
  const T wx0 = weight[0][lane], wx1 = weight[1][lane], wx2 = weight[2][lane];
  const Two a = v01[0] * wx0, b = v01[2] * wx2;
  const One c = v2[0] * wx0, d = v2[2] * wx2;
  const One wz2 = all<One>(weight[8][lane]);
  const Two wz01 = join<T>(all<One>(weight[6][lane]), all<One>(weight[7][lane]));
  const Two sum01 = fma(v01[1], all<Two>(wx1), a + b) * wz01, x01 = (b - a) * wz01;
  const One sum2 = fma(v2[1], all<One>(wx1), c + d) * wz2;
  const Two t01 = fma(y01[2], all<Two>(wx2), fma(y01[1], all<Two>(wx1), y01[0] * wx0)) * wz01;
  const One t2 = fma(y2[2], all<One>(wx2), fma(y2[1], all<One>(wx1), y2[0] * wx0));
  const One low = low_node<T>(sum01);
  store(out, low + high_node<T>(sum01) + sum2);
  store(out + 4, fma(d - c, wz2, low_node<T>(x01) + high_node<T>(x01)));
  store(out + 8, fma(t2, wz2, low_node<T>(t01) + high_node<T>(t01)));
  store(out + 12, sum2 - low);
}

/// C of the moments that `gather_one` writes, taken about the particle, whose distance from the middle node is
/// (x, y, z) cells.
template <class T>
INLINE void about_particle(const Pack<T>* sums, Pack<T> x, Pack<T> y, Pack<T> z, T scale, Pack<T>* C) {
  for (int a = 0; a < 3; ++a) {
    C[3 * a] = scale * (sums[4 + a] - x * sums[a]);
    C[3 * a + 1] = scale * (sums[8 + a] - y * sums[a]);
    C[3 * a + 2] = scale * (sums[12 + a] - z * sums[a]);
  }
}

template <class T, bool kFlip>
INLINE void gather_run(const GatherInput<T>& in, GatherReport<T>& report) {
  const ParticleRun<T>& run = in.run;
  alignas(64) T patch[6 * kPlane];
  alignas(64) T old_patch[kFlip ? 6 * kPlane : 1];
  fill_patch(in.node, patch);
  if constexpr (kFlip) fill_patch(in.old_node, old_patch);

  alignas(64) T weight[9][kLanes];
  alignas(64) T moment[kLanes][16];
  T* moment_at[kLanes];
  for (int l = 0; l < kLanes; ++l) moment_at[l] = moment[l];
  int corner[kLanes];
  Pack<T> fastest{};
  auto sound = fastest == fastest;
  report = {T(0), run.count, 0, 0, true};
  for (int first = 0; first < run.count; first += kLanes) {
    prefetch(run, first, 3);
    T* at[kLanes];
    const int lanes = point_at(run, first, at);
    Pack<T> place[12], rest[12];
    load_group<T>(at, kPlaceGroup, place);
    const SplinePack<T> sx((place[0] - run.origin[0]) * run.inverse_dx),
        sy((place[1] - run.origin[1]) * run.inverse_dx), sz((place[2] - run.origin[2]) * run.inverse_dx);
    for (int i = 0; i < 3; ++i) {
      store(weight[i], sx.weight[i]);
      store(weight[3 + i], sy.weight[i]);
      store(weight[6 + i], sz.weight[i]);
    }
    corners<T>(sx.base, sy.base, sz.base, corner);
    for (int l = 0; l < lanes; ++l) gather_one<T>(patch + corner[l], weight, l, moment[l]);
    for (int l = lanes; l < kLanes; ++l) __builtin_memcpy(moment[l], moment[lanes - 1], sizeof moment[l]);
    Pack<T> sums[16];
    for (int k = 0; k < 16; k += 4) load_group<T>(moment_at, k, sums + k);

    const Pack<T>* v = sums;
    Pack<T> C[9], new_v[3] = {v[0], v[1], v[2]}, new_C[9];
    about_particle<T>(sums, sx.offset - T(1), sy.offset - T(1), sz.offset - T(1), 4 * run.inverse_dx, C);
    for (int k = 0; k < 9; ++k) new_C[k] = C[k];
    if constexpr (kFlip) {
      // Single lanes are read from memory, which without FLIP would cost a quarter of the step.
      if (in.grid_C)
        for (int l = 0; l < lanes; ++l)
          for (int k = 0; k < 9; ++k) in.grid_C[9 * (first + l) + k] = C[k][l];
    }
    Pack<T> speed = fma(v[2], v[2], fma(v[1], v[1], v[0] * v[0]));

    for (int k = 4; k < 12; k += 4) load_group<T>(at, kPlaceGroup + k, place + k);
    for (int k = 0; k < 12; k += 4) load_group<T>(at, kRestGroup + k, rest + k);
    Pack<T>*F = place + 3, dF[9];
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 3; ++c)
        dF[3 * a + c] = in.dt * fma(C[3 * a + 2], F[6 + c], fma(C[3 * a + 1], F[3 + c], C[3 * a] * F[c]));
    Pack<T> size = speed;
    for (int k = 0; k < 9; ++k) {
      accumulate(F[k], rest[3 + k], dF[k]);
      size = fma(F[k], F[k], size);
    }
    sound &= size < all<Pack<T>>(T(1e18));  // also false for NaN; such a step is given up

    if constexpr (kFlip) {
      for (int l = 0; l < lanes; ++l) gather_one<T>(old_patch + corner[l], weight, l, moment[l]);
      for (int l = lanes; l < kLanes; ++l) __builtin_memcpy(moment[l], moment[lanes - 1], sizeof moment[l]);
      Pack<T> old_sums[16], motion[12], old_C[9];
      for (int k = 0; k < 16; k += 4) load_group<T>(moment_at, k, old_sums + k);
      for (int k = 0; k < 12; k += 4) load_group<T>(at, kVelocityGroup + k, motion + k);
      about_particle<T>(old_sums, sx.offset - T(1), sy.offset - T(1), sz.offset - T(1), 4 * run.inverse_dx, old_C);
      const Pack<T> flip = all<Pack<T>>(in.flip);
      for (int a = 0; a < 3; ++a) new_v[a] = fma(flip, motion[a] - old_sums[a], v[a]);
      for (int k = 0; k < 9; ++k) new_C[k] = fma(flip, motion[3 + k] - old_C[k], C[k]);
      speed = higher(speed, fma(new_v[2], new_v[2], fma(new_v[1], new_v[1], new_v[0] * new_v[0])));
    }
    fastest = higher(fastest, speed);
    Mask<T> strayed{}, left{};
    for (int a = 0; a < 3; ++a) {
      accumulate(place[a], rest[a], in.dt * v[a]);
      const Pack<T> inside = lower(higher(place[a], all<Pack<T>>(in.low[a])), all<Pack<T>>(in.high[a]));
      const auto out = inside != place[a];
      place[a] = inside;
      rest[a] = out ? Pack<T>{} : rest[a];
      new_v[a] = out ? Pack<T>{} : new_v[a];
      strayed |= out;
      left |= (stencil_base<T>((place[a] - run.origin[a]) * run.inverse_dx) >> 2) != in.block[a];
    }
    const uint32_t used = (1u << lanes) - 1;
    if (const uint32_t bits = lane_bits(strayed) & used) report.strays += __builtin_popcount(bits);
    for (uint32_t bits = lane_bits(left) & used; bits != 0; bits &= bits - 1)
      in.moved[report.moves++] = first + __builtin_ctz(bits);

    for (int k = 0; k < 12; k += 4)
      store_group<T>(at, kPlaceGroup + k, place[k], place[k + 1], place[k + 2], place[k + 3]);
    store_group<T>(at, kVelocityGroup, new_v[0], new_v[1], new_v[2], new_C[0]);
    store_group<T>(at, kVelocityGroup + 4, new_C[1], new_C[2], new_C[3], new_C[4]);
    store_group<T>(at, kVelocityGroup + 8, new_C[5], new_C[6], new_C[7], new_C[8]);
    for (int k = 0; k < 12; k += 4) store_group<T>(at, kRestGroup + k, rest[k], rest[k + 1], rest[k + 2], rest[k + 3]);
  }
  for (int l = 0; l < kLanes; ++l)
    if (fastest[l] > report.max_speed_squared) report.max_speed_squared = fastest[l];
  report.finite = lane_bits(~sound) == 0;
}

template <class T>
void gather(const GatherInput<T>& in, GatherReport<T>& report) {
  if (in.flip > T(0))
    gather_run<T, true>(in, report);
  else
    gather_run<T, false>(in, report);
}

}  // namespace pliant::PLIANT_ISA
