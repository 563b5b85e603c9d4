#pragma once

#include "physics/mpm/kernels/elastic_kernels.h"
#include "physics/mpm/kernels/piola_adjoint_kernels.h"
#include "physics/mpm/kernels/step_adjoint_view.h"

// Lagrangian runs backwards: weights are constants, so that a scatter is the whole way back of a gather and a gather
// that of a scatter.

namespace pliant::PLIANT_ISA {

/// Derivatives of the law and of the viscosity by F, its rate and the constants; A = dL/dP.
template <class T>
struct ElasticStressAdjoint {
  StressAdjointPack<T> by;
  Pack<T> by_rate[9], by_viscosity_time;
};

template <class T, Mixture kMixture>
INLINE void total_piola_adjoint(const ElasticAdjointRun<T>& in, StressKind kind, const Pack<T>* F, const Pack<T>* dF,
                                const Pack<T>* constant, const Pack<T>* further, Pack<T> viscosity_time,
                                const Pack<T>* A, ElasticStressAdjoint<T>& out) {
  const ElasticRun<T>& run = in.run;
  const Pack<T> mu = constant[2], lambda = constant[3];
  StressAdjointPack<T>& by = out.by;
  if constexpr (kMixture == Mixture::kUniform) {
    law_piola_adjoint<T>(in, kind, F, mu, lambda, A, by);
    return;
  }
  for (int k = 0; k < 9; ++k) by.F[k] = Pack<T>{};
  by.mu = by.lambda = out.by_viscosity_time = Pack<T>{};
  const StressKind laws[2] = {StressKind::kFixedCorotated, StressKind::kNeoHookean};
  for (const StressKind law : laws) {
    const auto mine = further[2] == all<Pack<T>>(static_cast<T>(static_cast<int>(law)));
    if (lane_bits(mine) == 0) continue;
    Pack<T> shaped[9];
    StressAdjointPack<T> part;
    for (int k = 0; k < 9; ++k) shaped[k] = mine ? F[k] : all<Pack<T>>(T(k % 4 == 0));
    law_piola_adjoint<T>(in, law, shaped, mu, lambda, A, part);
    for (int k = 0; k < 9; ++k) by.F[k] = mine ? part.F[k] : by.F[k];
    by.mu = mine ? part.mu : by.mu;
    by.lambda = mine ? part.lambda : by.lambda;
  }
  const auto exact = further[2] == all<Pack<T>>(static_cast<T>(static_cast<int>(StressKind::kHencky)));
  repair_piola_adjoint<T>(lane_bits(exact), in, StressKind::kHencky, F, mu, lambda, A, by);
  if (!run.viscous) return;
  for (int k = 0; k < 9; ++k) out.by_rate[k] = Pack<T>{};
  const Pack<T> loads = all<Pack<T>>(run.viscosity_time);
  const ViscosityAdjointPack<T> by_viscosity =
      viscous_piola_adjoint<T>(F, dF, fma(loads, mu, further[0]), fma(loads, lambda, further[1]), A, by.F, out.by_rate);
  const Pack<T> time = loads + viscosity_time;
  by.mu = fma(by_viscosity.shear, time, by.mu);
  by.lambda = fma(by_viscosity.bulk, time, by.lambda);
  out.by_viscosity_time = fma(by_viscosity.shear, mu, by_viscosity.bulk * lambda);
}

/// The impulses of a step backwards.  `adj` holds the derivatives by the impulses of the nodes of the block's patch
/// and, in the fourth lane, by their mass; those by displacements and, where the stress is viscous, by velocities are
/// written to two patches, those by the particles' constants added to `record`.
template <class T, Mixture kMixture>
INLINE void elastic_impulses_adjoint(const ElasticAdjointRun<T>& in, StressKind kind, const T* adj,
                                     AdjointRecord<T>* record, T* by_displacement, T* by_velocity) {
  const ElasticRun<T>& run = in.run;
  alignas(64) T displacement[6 * kPlane];
  alignas(64) T velocity[kMixture == Mixture::kAny ? 6 * kPlane : 1];
  OneNode<T> common;
  fill_displacements(run, displacement, common);
  const bool viscous = kMixture == Mixture::kAny && run.viscous;
  if (viscous) fill_velocities(run, velocity);
  for (int k = 0; k < 6 * kPlane; k += 8) {
    store(by_displacement + k, TwoNodes<T>{});
    store(by_velocity + k, TwoNodes<T>{});
  }
  const T stress_scale = -run.dt, per_distance = 4 * run.inverse_dx;
  for (int first = 0; first < run.count; first += kLanes) {
    const T* at[kLanes];
    T* record_at[kLanes];
    const int lanes = point_at(run, first, at);
    for (int l = 0; l < kLanes; ++l) record_at[l] = reinterpret_cast<T*>(record + first + (l < lanes ? l : lanes - 1));
    Pack<T> X[4], constant[4], further[4], total[4], rest[4];
    load_group<T>(at, 0, X);
    load_group<T>(at, 4, constant);
    if constexpr (kMixture == Mixture::kAny) {
      load_group<T>(at, 8, further);
      load_group<T>(record_at, kAdjointRest, rest);
    }
    load_group<T>(record_at, kAdjointSum, total);
    const RestStencil<T> stencil(run, X);
    Pack<T> u[4], gradient[9], undisplaced[12], F[9], v[4], dF[9] = {}, a[4], a_gradient[9], A[9];
    stencil.gather(lanes, displacement, run.inverse_dx, u, gradient);
    deformation(run, first, lanes, gradient, undisplaced, F);
    if (viscous) stencil.gather(lanes, velocity, run.inverse_dx, v, dF);
    stencil.gather(lanes, adj, run.inverse_dx, a, a_gradient);
    const Pack<T> s = stress_scale * constant[1];
    for (int k = 0; k < 9; ++k) A[k] = s * a_gradient[k];
    ElasticStressAdjoint<T> stress;
    total_piola_adjoint<T, kMixture>(in, kind, F, dF, constant, further, rest[1], A, stress);

    // The particle's part of the stabilization, whose stiffness is so much of mu.
    const Pack<T> stiffness = run.dt * X[3], per_cell = stiffness * run.dx, quarter = all<Pack<T>>(run.dx * run.dx / 4);
    Pack<T> by_stiffness{}, by_gradient{}, by_mass = a[3];
    for (int b = 0; b < 3; ++b) by_stiffness = fma(a[b], u[b] + common[b], by_stiffness);
    for (int k = 0; k < 9; ++k) by_gradient = fma(a_gradient[k], gradient[k], by_gradient);
    by_stiffness = fma(quarter, by_gradient, by_stiffness);
    Pack<T> value[4] = {stiffness * a[0], stiffness * a[1], stiffness * a[2], stiffness}, along[3][3];
    for (int c = 0; c < 3; ++c)
      for (int b = 0; b < 3; ++b)
        along[c][b] = fma(per_cell, a_gradient[3 * b + c], per_distance * stress.by.F[3 * b + c]);
    stencil.scatter(lanes, value, along, by_displacement);
    if (viscous) {
      const Pack<T> none[4] = {};
      for (int c = 0; c < 3; ++c)
        for (int b = 0; b < 3; ++b) along[c][b] = per_distance * stress.by_rate[3 * b + c];
      stencil.scatter(lanes, none, along, by_velocity);
      total[3] += stress.by_viscosity_time;
    }
    if (run.gain)
      for (int l = 0; l < kLanes; ++l)  // spare lanes, too: all of one particle are stored in the same place
        for (int b = 0; b < 3; ++b) {
          const int k = 3 * (first + (l < lanes ? l : lanes - 1)) + b;
          by_mass[l] += a[b][l] * run.gain[k];
          in.by_gain[k] = constant[0][l] * a[b][l];
        }
    if (in.by_undisplaced)
      for (int l = 0; l < lanes; ++l)
        for (int k = 0; k < 9; ++k) in.by_undisplaced[12 * (first + l) + 3 + k] += stress.by.F[k][l];
    total[0] += by_mass;
    total[1] += fma(by_stiffness, stiffness / constant[2], stress.by.mu);
    total[2] += stress.by.lambda;
    store_group<T>(record_at, kAdjointSum, total[0], total[1], total[2], total[3]);
  }
  subtract_own_part(run, adj, by_displacement);
}

template <class T>
void elastic_impulses_adjoint_fixed_corotated(const ElasticAdjointRun<T>& in, const T* adj, AdjointRecord<T>* record,
                                              T* by_displacement, T* by_velocity) {
  elastic_impulses_adjoint<T, Mixture::kUniform>(in, StressKind::kFixedCorotated, adj, record, by_displacement,
                                                 by_velocity);
}
template <class T>
void elastic_impulses_adjoint_neo_hookean(const ElasticAdjointRun<T>& in, const T* adj, AdjointRecord<T>* record,
                                          T* by_displacement, T* by_velocity) {
  elastic_impulses_adjoint<T, Mixture::kUniform>(in, StressKind::kNeoHookean, adj, record, by_displacement,
                                                 by_velocity);
}
template <class T>
void elastic_impulses_adjoint_any(const ElasticAdjointRun<T>& in, const T* adj, AdjointRecord<T>* record,
                                  T* by_displacement, T* by_velocity) {
  elastic_impulses_adjoint<T, Mixture::kAny>(in, StressKind::kGiven, adj, record, by_displacement, by_velocity);
}

/// Adds the derivatives by x and F, and by v and C, that `record` holds to those by displacements and velocities.
template <class T>
void follow_nodes_adjoint(const ElasticRun<T>& run, const AdjointRecord<T>* record, T* by_displacement,
                          T* by_velocity) {
  const T per_distance = 4 * run.inverse_dx;
  for (int first = 0; first < run.count; first += kLanes) {
    const T *at[kLanes], *record_at[kLanes];
    const int lanes = point_at(run, first, at);
    for (int l = 0; l < kLanes; ++l)
      record_at[l] = reinterpret_cast<const T*>(record + first + (l < lanes ? l : lanes - 1));
    Pack<T> X[4], by[24];
    load_group<T>(at, 0, X);
    for (int k = 0; k < 24; k += 4) load_group<T>(record_at, kAdjointPlace + k, by + k);
    const RestStencil<T> stencil(run, X);
    for (int half = 0; half < 24; half += 12) {
      Pack<T> value[4] = {by[half], by[half + 1], by[half + 2], Pack<T>{}}, along[3][3];
      for (int c = 0; c < 3; ++c)
        for (int b = 0; b < 3; ++b) along[c][b] = per_distance * by[half + 3 + 3 * b + c];
      stencil.scatter(lanes, value, along, half ? by_velocity : by_displacement);
    }
  }
}

}  // namespace pliant::PLIANT_ISA
