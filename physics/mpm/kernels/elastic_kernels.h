#pragma once

#include "physics/mpm/kernels/gather_kernels.h"
#include "physics/mpm/kernels/scatter_kernels.h"

// Lagrangian runs, where stencils and weights are those at rest: x = X + sum w u_i, F = I + 4 / dx^2 sum w u_i d^T,
// likewise v and the rate C of F, with d the distance of the node from the particle at rest.

namespace pliant::PLIANT_ISA {

/// The particles of a pack; spare lanes repeat the last one.
template <class T>
INLINE int point_at(const ElasticRun<T>& run, int first, const T** at) {
  const int left = run.count - first, lanes = left < kLanes ? left : kLanes;
  for (int l = 0; l < kLanes; ++l)
    at[l] = reinterpret_cast<const T*>(run.particle + first + (l < lanes ? l : lanes - 1));
  return lanes;
}

/// Splines of a pack laid out for one lane at a time.
template <class T>
struct RestStencil {
  alignas(64) T weight[9][kLanes];    // along x, y, z
  alignas(64) T product[12][kLanes];  // of x times y, then along z
  int corner[kLanes];
  Pack<T> offset[3];  // of the particles from their lowest nodes, cells

  INLINE RestStencil(const ElasticRun<T>& run, const Pack<T>* X) {
    const SplinePack<T> sx((X[0] - run.origin[0]) * run.inverse_dx), sy((X[1] - run.origin[1]) * run.inverse_dx),
        sz((X[2] - run.origin[2]) * run.inverse_dx);
    for (int i = 0; i < 3; ++i) {
      store(weight[i], sx.weight[i]);
      store(weight[3 + i], sy.weight[i]);
      store(weight[6 + i], sz.weight[i]);
      for (int j = 0; j < 3; ++j) store(product[3 * i + j], sx.weight[i] * sy.weight[j]);
      store(product[9 + i], sz.weight[i]);
    }
    corners<T>(sx.base, sy.base, sz.base, corner);
    offset[0] = sx.offset;
    offset[1] = sy.offset;
    offset[2] = sz.offset;
  }

  /// value[4] = sum w a_i, and gradient[9] = 4 / dx^2 sum w a_i d^T of its first three lanes.
  INLINE void gather(int lanes, const T* patch, T inverse_dx, Pack<T>* value, Pack<T>* gradient) const {
    alignas(64) T moment[kLanes][16];
    const T* moment_at[kLanes];
    for (int l = 0; l < kLanes; ++l) moment_at[l] = moment[l < lanes ? l : lanes - 1];
    for (int l = 0; l < lanes; ++l) gather_one<T>(patch + corner[l], weight, l, moment[l]);
    Pack<T> sums[16];
    for (int k = 0; k < 16; k += 4) load_group<T>(moment_at, k, sums + k);
    for (int k = 0; k < 4; ++k) value[k] = sums[k];
    about_particle<T>(sums, offset[0] - T(1), offset[1] - T(1), offset[2] - T(1), 4 * inverse_dx, gradient);
  }

  /// Adds w (value + along d) with d in cells, along[axis][3]; value[3] goes to the fourth lane.
  INLINE void scatter(int lanes, const Pack<T>* value, const Pack<T> (*along)[3], T* patch) const {
    alignas(64) T affine[kLanes][16];
    T* affine_at[kLanes];
    for (int l = 0; l < kLanes; ++l) affine_at[l] = affine[l];
    Pack<T> base[3];
    for (int b = 0; b < 3; ++b) {
      base[b] = value[b];
      for (int a = 0; a < 3; ++a) base[b] -= along[a][b] * offset[a];
    }
    store_group<T>(affine_at, 0, base[0], base[1], base[2], value[3]);
    for (int a = 0; a < 3; ++a) store_group<T>(affine_at, 4 + 4 * a, along[a][0], along[a][1], along[a][2], Pack<T>{});
    for (int l = 0; l < lanes; ++l) scatter_one<T>(affine[l], product, l, patch + corner[l]);
  }
};

/// Displacements of the nodes of a block's patch less `common`, that of the node nearest to its first particle, which
/// strains nothing: so digits are not lost where a body has gone far.
template <class T>
INLINE void fill_displacements(const ElasticRun<T>& run, T* patch, OneNode<T>& common) {
  int block = 0, node = 0;
  for (int a = 0; a < 3; ++a) {
    const T t = (run.particle->X[a] - run.origin[a]) * run.inverse_dx + T(0.5);
    const int cut = static_cast<int>(t), at = ((cut - (static_cast<T>(cut) > t) - 1) & 3) + 1;
    block = block * 2 + (at >> 2);
    node = node * 4 + (at & 3);
  }
  common = load<OneNode<T>>(run.displacement[block] + 4 * node);
  const TwoNodes<T> both = join<T>(common, common);
  for (int i = 0; i < run.pairs; ++i) {
    const ReachedPair p = run.pair[i];
    store(patch + 8 * p.patch, load<TwoNodes<T>>(run.displacement[p.block] + 8 * p.node) - both);
  }
}

template <class T>
INLINE void fill_velocities(const ElasticRun<T>& run, T* patch) {
  for (int i = 0; i < run.pairs; ++i) {
    const ReachedPair p = run.pair[i];
    store(patch + 8 * p.patch, load<TwoNodes<T>>(run.velocity[p.block] + 8 * p.node));
  }
}

/// F of a pack from the gradient of the displacement.
template <class T>
INLINE void deformation(const ElasticRun<T>& run, int first, int lanes, const Pack<T>* gradient, Pack<T>* undisplaced,
                        Pack<T>* F) {
  for (int k = 0; k < 9; ++k) F[k] = gradient[k] + T(k % 4 == 0);
  for (int k = 0; k < 12; ++k) undisplaced[k] = Pack<T>{};
  if (!run.undisplaced) return;
  const T* at[kLanes];
  for (int l = 0; l < kLanes; ++l) at[l] = run.undisplaced + 12 * (first + (l < lanes ? l : lanes - 1));
  for (int k = 0; k < 12; k += 4) load_group<T>(at, k, undisplaced + k);
  for (int k = 0; k < 9; ++k) F[k] += undisplaced[3 + k];
}

/// First Piola-Kirchhoff stress of the pack, viscosity included; `dF` is the rate of F, `further` the last group of
/// RestParticle.
template <class T, Mixture kMixture>
INLINE void total_piola(const ElasticRun<T>& in, StressKind kind, const Pack<T>* F, const Pack<T>* dF, Pack<T> mu,
                        Pack<T> lambda, const Pack<T>* further, Pack<T>* P) {
  if constexpr (kMixture == Mixture::kUniform) {
    pack_piola<T>(kind, F, mu, lambda, in.exact_piola, P);
    return;
  }
  for (int k = 0; k < 9; ++k) P[k] = Pack<T>{};
  const StressKind laws[2] = {StressKind::kFixedCorotated, StressKind::kNeoHookean};
  for (const StressKind one : laws) {
    const auto mine = further[2] == all<Pack<T>>(static_cast<T>(static_cast<int>(one)));
    if (lane_bits(mine) == 0) continue;
    Pack<T> shaped[9], part[9];
    for (int k = 0; k < 9; ++k) shaped[k] = mine ? F[k] : all<Pack<T>>(T(k % 4 == 0));
    pack_piola<T>(one, shaped, mu, lambda, in.exact_piola, part);
    for (int k = 0; k < 9; ++k) P[k] = mine ? part[k] : P[k];
  }
  const auto exact = further[2] == all<Pack<T>>(static_cast<T>(static_cast<int>(StressKind::kHencky)));
  if (const uint32_t lanes = lane_bits(exact); lanes != 0)
    repair_piola<T>(lanes, StressKind::kHencky, F, mu, lambda, in.exact_piola, P);
  if (!in.viscous) return;
  // Kelvin-Voigt: the linear law applied to the strain rate L = dF F^-1, taken back by F^-T.
  Pack<T> inverse[9], L[9], tau[9], viscous[9];
  safe_inverse<T>(F, inverse);
  multiply<false, false, T>(dF, inverse, L);
  const Pack<T> time = all<Pack<T>>(in.viscosity_time), shear = fma(time, mu, further[0]);
  const Pack<T> pressure = fma(time, lambda, further[1]) * (L[0] + L[4] + L[8]);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) tau[3 * i + j] = shear * (L[3 * i + j] + L[3 * j + i]);
  for (int k = 0; k < 9; k += 4) tau[k] += pressure;
  multiply<false, true, T>(tau, inverse, viscous);
  for (int k = 0; k < 9; ++k) P[k] += viscous[k];
}

template <class T>
INLINE void clear_patch(const ElasticRun<T>& run, T* patch) {
  for (int i = 0; i < run.pairs; ++i) store(patch + 8 * run.pair[i].patch, TwoNodes<T>{});
}

/// patch -= its fourth lane times a, node by node: the nodes' own part of the stabilization.
template <class T>
INLINE void subtract_own_part(const ElasticRun<T>& run, const T* a, T* patch) {
  using Two = TwoNodes<T>;
  for (int i = 0; i < run.pairs; ++i) {
    const int k = 8 * run.pair[i].patch;
    const Two sum = load<Two>(patch + k), own = __builtin_shufflevector(sum, sum, 3, 3, 3, 3, 7, 7, 7, 7);
    store(patch + k, sum - own * load<Two>(a + k));
  }
}

template <class T, Mixture kMixture>
INLINE void elastic_impulses(const ElasticRun<T>& run, StressKind kind, T* patch) {
  alignas(64) T displacement[6 * kPlane];
  alignas(64) T velocity[kMixture == Mixture::kAny ? 6 * kPlane : 1];
  OneNode<T> common;
  fill_displacements(run, displacement, common);
  if (kMixture == Mixture::kAny && run.viscous) fill_velocities(run, velocity);
  clear_patch(run, patch);
  const T stress_scale = -run.dt * 4 * run.inverse_dx;  // times V P, per cell of distance
  for (int first = 0; first < run.count; first += kLanes) {
    const T* at[kLanes];
    const int lanes = point_at(run, first, at);
    Pack<T> X[4], constant[4], further[4], u[4], gradient[9], undisplaced[12], F[9], v[4], dF[9] = {}, P[9];
    load_group<T>(at, 0, X);
    load_group<T>(at, 4, constant);
    if constexpr (kMixture == Mixture::kAny) load_group<T>(at, 8, further);
    const RestStencil<T> stencil(run, X);
    stencil.gather(lanes, displacement, run.inverse_dx, u, gradient);
    deformation(run, first, lanes, gradient, undisplaced, F);
    if (kMixture == Mixture::kAny && run.viscous) stencil.gather(lanes, velocity, run.inverse_dx, v, dF);
    total_piola<T, kMixture>(run, kind, F, dF, constant[2], constant[3], further, P);

    const Pack<T> s = stress_scale * constant[1], stiffness = run.dt * X[3], per_cell = stiffness * run.dx;
    Pack<T> value[4] = {stiffness * u[0], stiffness * u[1], stiffness * u[2], stiffness}, along[3][3];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) along[a][b] = fma(per_cell, gradient[3 * b + a], s * P[3 * b + a]);
    if (run.gain)
      for (int l = 0; l < lanes; ++l)
        for (int b = 0; b < 3; ++b) value[b][l] += constant[0][l] * run.gain[3 * (first + l) + b];
    stencil.scatter(lanes, value, along, patch);
  }
  subtract_own_part(run, displacement, patch);
}

template <class T>
void elastic_impulses_fixed_corotated(const ElasticRun<T>& run, T* patch) {
  elastic_impulses<T, Mixture::kUniform>(run, StressKind::kFixedCorotated, patch);
}
template <class T>
void elastic_impulses_neo_hookean(const ElasticRun<T>& run, T* patch) {
  elastic_impulses<T, Mixture::kUniform>(run, StressKind::kNeoHookean, patch);
}
template <class T>
void elastic_impulses_any(const ElasticRun<T>& run, T* patch) {
  elastic_impulses<T, Mixture::kAny>(run, StressKind::kGiven, patch);
}

/// kPlace: x and F, else v and C.
template <class T, bool kPlace>
INLINE void follow_half(const ElasticRun<T>& run, TapeParticle<T>* out) {
  alignas(64) T nodes[6 * kPlane];
  OneNode<T> common{};
  if constexpr (kPlace)
    fill_displacements(run, nodes, common);
  else
    fill_velocities(run, nodes);
  for (int first = 0; first < run.count; first += kLanes) {
    const T* at[kLanes];
    const int lanes = point_at(run, first, at);
    Pack<T> X[4], value[4], gradient[9];
    load_group<T>(at, 0, X);
    const RestStencil<T> stencil(run, X);
    stencil.gather(lanes, nodes, run.inverse_dx, value, gradient);
    if constexpr (kPlace) {
      Pack<T> undisplaced[12], F[9];
      deformation(run, first, lanes, gradient, undisplaced, F);
      for (int a = 0; a < 3; ++a) value[a] = X[a] + common[a] + (value[a] + undisplaced[a]);
      for (int k = 0; k < 9; ++k) gradient[k] = F[k];
    }
    T* to[kLanes];
    for (int l = 0; l < kLanes; ++l) to[l] = reinterpret_cast<T*>(out + first + (l < lanes ? l : lanes - 1));
    constexpr int kAt = kPlace ? kTapePlace : kTapeVelocity;
    store_group<T>(to, kAt, value[0], value[1], value[2], gradient[0]);
    store_group<T>(to, kAt + 4, gradient[1], gradient[2], gradient[3], gradient[4]);
    store_group<T>(to, kAt + 8, gradient[5], gradient[6], gradient[7], gradient[8]);
  }
}

template <class T>
void follow_nodes(const ElasticRun<T>& run, Follow what, TapeParticle<T>* out) {
  if (what != Follow::kMotion) follow_half<T, true>(run, out);
  if (what != Follow::kPlace) follow_half<T, false>(run, out);
}

template <class T>
void add_pairs(const ReachedPair* pair, int count, const T* patch, T* node) {
  using Two = TwoNodes<T>;
  for (int i = 0; i < count; ++i) {
    T* to = node + 8 * pair[i].node;
    store(to, load<Two>(to) + load<Two>(patch + 8 * pair[i].patch));
  }
}

/// Calls visit(place) of every pair of nodes in `active`, as steps of numbers.
template <class Visit>
INLINE void for_active_pairs(uint32_t active, Visit&& visit) {
  for (; active != 0; active &= active - 1) visit(8 * __builtin_ctz(active));
}

template <class T>
void push_nodes(uint32_t active, const T* impulse, const T* kept, const T* fall, T scale, T* velocity) {
  using Two = TwoNodes<T>;
  const Two dv = {fall[0], fall[1], fall[2], 0, fall[0], fall[1], fall[2], 0};
  const Two is_mass = {0, 0, 0, 1, 0, 0, 0, 1};
  for_active_pairs(active, [&](int k) {
    Two v = load<Two>(velocity + k);
    const Two mass = __builtin_shufflevector(v, v, 3, 3, 3, 3, 7, 7, 7, 7), old = v;
    if (kept) v *= join<T>(all<OneNode<T>>(kept[k / 4]), all<OneNode<T>>(kept[k / 4 + 1]));
    v = fma(load<Two>(impulse + k), T(1) / mass, v + dv) * scale;
    v = is_mass > Two{} ? old : v;
    store(velocity + k, mass > Two{} ? v : Two{});
  });
}

template <class T>
void displace_nodes(uint32_t active, const T* velocity, T dt, const NodeFrame<T>& frame, T* displacement, T* rest,
                    NodeReport<T>& report) {
  using Two = TwoNodes<T>;
  const T* r = frame.drift;
  const Two moves = {dt, dt, dt, 0, dt, dt, dt, 0}, drift = {r[0], r[1], r[2], 0, r[0], r[1], r[2], 0};
  const Two limit = all<Two>(T(1e18));
  const Two far = all<Two>(T(1e30));
  Two fastest{}, momentum{}, low = far, high = -far;
  auto sound = fastest == fastest;
  for_active_pairs(active, [&](int k) {
    Two u = load<Two>(displacement + k), below = load<Two>(rest + k);
    const Two v = load<Two>(velocity + k), mass = __builtin_shufflevector(v, v, 3, 3, 3, 3, 7, 7, 7, 7);
    accumulate(u, below, v * moves);
    low = mass > Two{} ? (u < low ? u : low) : low;
    high = mass > Two{} ? (u > high ? u : high) : high;
    store(displacement + k, u);
    store(rest + k, below);
    const Two seen = join<T>(all<OneNode<T>>(frame.seen[k / 4]), all<OneNode<T>>(frame.seen[k / 4 + 1]));
    const Two relative = (v - drift) * seen, square = relative * relative;
    const Two speed = square + __builtin_shufflevector(square, square, 1, 2, 0, 3, 5, 6, 4, 7) +
                      __builtin_shufflevector(square, square, 2, 0, 1, 3, 6, 4, 5, 7);
    sound &= speed < limit;  // also false for NaN
    fastest = speed > fastest ? speed : fastest;
    momentum = fma(v, mass, momentum);
  });
  bool good = true;
  report.max_speed_squared = 0;
  for (int k = 0; k < 8; ++k) {
    if (k % 4 == 3) continue;  // the mass
    if (fastest[k] > report.max_speed_squared) report.max_speed_squared = fastest[k];
    good &= sound[k] != 0;
  }
  for (int a = 0; a < 3; ++a) {
    report.momentum[a] = momentum[a] + momentum[a + 4];
    report.low[a] = low[a] < low[a + 4] ? low[a] : low[a + 4];
    report.high[a] = high[a] > high[a + 4] ? high[a] : high[a + 4];
  }
  if (!good) report.max_speed_squared = T(1) / T(0);
}

}  // namespace pliant::PLIANT_ISA
