#pragma once

// Particles of one block in the reverse direction.  Included with PLIANT_ISA set to the namespace of the code.

#include "physics/mpm/step_adjoint_view.h"
#include "physics/mpm/stress_adjoint_kernels.h"
#include "physics/mpm/transfer_adjoint_kernels.h"

namespace pliant::PLIANT_ISA {

/// v' = sum w v_i, C' = 4 / dx^2 sum w v_i (x_i - x)^T, F' = (I + dt C') F, x' = x + dt v', backwards.
template <class T>
void reverse_gather(const AdjointView<T>& view, int first, int last, const Node<T>* velocity, Node<T>* patch) {
  using P = Pack<T>;
  const T dt = view.dt, c_scale = 4 * view.inverse_dx;
  for (int s = first; s < last; ++s) {
    const TapeParticle<T>& p = view.particle[s];
    AdjointRecord<T>& r = view.record[view.slot[view.index[s]]];
    for (int a = 0; a < 3; ++a)
      if (r.put_back >> a & 1) r.x[a] = r.v[a] = 0;
    T g[3], G[9], F[9];
    for (int a = 0; a < 3; ++a) g[a] = r.v[a] + dt * r.x[a];
    for (int a = 0; a < 3; ++a) {
      const T* f = r.F + 3 * a;
      for (int c = 0; c < 3; ++c) {
        const T* row = p.F + 3 * c;
        G[3 * a + c] = c_scale * (r.C[3 * a + c] + dt * (f[0] * row[0] + f[1] * row[1] + f[2] * row[2]));
        F[3 * a + c] = r.F[3 * a + c] + dt * (r.C_after[a] * r.F[c] + r.C_after[3 + a] * r.F[3 + c] +
                                              r.C_after[6 + a] * r.F[6 + c]);
      }
    }
    const Stencil<T> stencil(p.x, view.origin, view.inverse_dx);
    const Affine<T> h{P{g[0], g[1], g[2], 0},
                      {P{G[0], G[3], G[6], 0}, P{G[1], G[4], G[7], 0}, P{G[2], G[5], G[8], 0}}};
    T by_position[3];
    const P* u = reinterpret_cast<const P*>(velocity);
    const P u_p = r.put_back ? value_at_particle<T>(stencil, u) : P{r.v_after[0], r.v_after[1], r.v_after[2], 0};
    scatter_with_slopes<T>(stencil, h, u, u_p, reinterpret_cast<P*>(patch), by_position);
    for (int a = 0; a < 3; ++a) r.x[a] += view.inverse_dx * by_position[a];
    for (int k = 0; k < 9; ++k) r.F[k] = F[k];
  }
}

/// m_i = sum w m, (m v)_i = sum w (m v + (m C - dt 4 / dx^2 V0 tau) (x_i - x)), backwards.
template <class T>
void reverse_scatter(const AdjointView<T>& view, int first, int last, const Node<T>* nodes, double* sums) {
  using P = Pack<T>;
  const T dt = view.dt;
  for (int s = first; s < last; ++s) {
    const TapeParticle<T>& p = view.particle[s];
    AdjointRecord<T>& r = view.record[view.slot[view.index[s]]];
    T tau[6];
    StressPoint<T> stress(p.F, r.mu, r.lambda);
    stress.kirchhoff(tau);
    T C_trace = 0, rate[6] = {};  // viscous: 2 mu sym(C) + lambda tr(C) I, times the viscosity time
    if (view.viscosity_time > T(0)) {
      C_trace = p.C[0] + p.C[4] + p.C[8];
      rate[0] = p.C[0], rate[1] = p.C[4], rate[2] = p.C[8];
      rate[3] = T(0.5) * (p.C[5] + p.C[7]), rate[4] = T(0.5) * (p.C[2] + p.C[6]), rate[5] = T(0.5) * (p.C[1] + p.C[3]);
      for (int k = 0; k < 6; ++k)
        tau[k] += view.viscosity_time * (2 * r.mu * rate[k] + (k < 3 ? r.lambda * C_trace : T(0)));
    }
    T v[3] = {p.v[0], p.v[1], p.v[2]}, kept = 1;
    if (r.bits != 0) {
      for (int l = 0; l < view.bodies; ++l) {
        const PlainBodyLoad<T>& load = view.body[l];
        if ((r.bits & load.bit) == 0) continue;
        kept -= dt * load.drag;
        for (int a = 0; a < 3; ++a) v[a] += dt * (load.acceleration[a] - load.drag * p.v[a]);
      }
    }
    const T stress_scale = -dt * 4 * view.inverse_dx * r.volume, m = r.mass * view.dx;
    const T t[9] = {tau[0], tau[5], tau[4], tau[5], tau[1], tau[3], tau[4], tau[3], tau[2]};
    Affine<T> q;
    q.value = P{r.mass * v[0], r.mass * v[1], r.mass * v[2], r.mass};
    for (int c = 0; c < 3; ++c)
      q.along[c] = P{m * p.C[c] + stress_scale * t[c], m * p.C[3 + c] + stress_scale * t[3 + c],
                     m * p.C[6 + c] + stress_scale * t[6 + c], 0};

    const Stencil<T> stencil(p.x, view.origin, view.inverse_dx);
    T by_position[3];
    const Affine<T> moment = gather_with_slopes<T>(stencil, q, reinterpret_cast<const P*>(nodes), by_position);
    T by_tau[9], C_dot = 0;
    for (int a = 0; a < 3; ++a) {
      r.x[a] += view.inverse_dx * by_position[a];
      r.v[a] = r.mass * kept * moment.value[a];
      for (int c = 0; c < 3; ++c) {
        by_tau[3 * a + c] = stress_scale * moment.along[c][a];
        r.C[3 * a + c] = m * moment.along[c][a];
        C_dot += p.C[3 * a + c] * moment.along[c][a];
      }
    }
    r.by_mass += v[0] * moment.value[0] + v[1] * moment.value[1] + v[2] * moment.value[2] + moment.value[3] +
                 view.dx * C_dot;
    if (r.bits != 0) {
      for (int l = 0; l < view.bodies; ++l) {
        if ((r.bits & view.body[l].bit) == 0) continue;
        double* sum = sums + 1 + 4 * l;
        for (int a = 0; a < 3; ++a) {
          const T by_v = dt * r.mass * moment.value[a];
          sum[a] += by_v;
          sum[3] -= by_v * p.v[a];
        }
      }
    }

    // tau is symmetric, so only the symmetric part of its derivative counts.
    const T S[6] = {by_tau[0],
                    by_tau[4],
                    by_tau[8],
                    T(0.5) * (by_tau[5] + by_tau[7]),
                    T(0.5) * (by_tau[2] + by_tau[6]),
                    T(0.5) * (by_tau[1] + by_tau[3])};
    stress.reverse(S, r.F, r.by_mu, r.by_lambda);
    if (view.viscosity_time > T(0)) {
      const T trace = S[0] + S[1] + S[2], time = view.viscosity_time;
      const T work = S[0] * rate[0] + S[1] * rate[1] + S[2] * rate[2] +
                     2 * (S[3] * rate[3] + S[4] * rate[4] + S[5] * rate[5]);
      const T full[9] = {S[0], S[5], S[4], S[5], S[1], S[3], S[4], S[3], S[2]};
      for (int k = 0; k < 9; ++k) r.C[k] += 2 * r.mu * time * full[k];
      for (int k = 0; k < 9; k += 4) r.C[k] += r.lambda * time * trace;
      r.by_mu += 2 * time * work;
      r.by_lambda += time * trace * C_trace;
      sums[0] += 2 * r.mu * work + r.lambda * trace * C_trace;
    }
    for (int k = 0; k < 3; ++k) r.v_after[k] = p.v[k];
    for (int k = 0; k < 9; ++k) r.C_after[k] = p.C[k];
    r.put_back = 0;
    for (int a = 0; a < 3; ++a) r.put_back |= static_cast<uint32_t>(p.x[a] == view.low[a] || p.x[a] == view.high[a]) << a;
  }
}

}  // namespace pliant::PLIANT_ISA
