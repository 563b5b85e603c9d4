#pragma once

#include <algorithm>
#include <cmath>

#include "gaussians/base/types.h"

namespace pliant {

/// Two particles of parts that do not hang together.  Nearer than `reach` they push each other apart like two springs
/// in a row that begin softly, along the line between them, with Coulomb friction across it:
///   J_n = 2 dt k depth^2 / reach, depth = reach - |x_0 - x_1|, k = k_0 k_1 / (k_0 + k_1)
///   J = J_n n - min(friction J_n / |t|, m / kStickSteps) t, t = relative velocity across n, m the reduced mass.
/// The forces are equal and opposite and, but for friction, along the line between their places, and have a potential.
template <class T>
struct ContactPair {
  Vec3<T> x[2], v[2];       ///< m, m/s
  T mass[2], stiffness[2];  ///< kg; N/m, (lambda + 2 mu) V / dx^2
  T reach;                  ///< m

  /// What sticks loses its relative velocity within so many steps; with several neighbours that is soon.
  static constexpr T kStickSteps = 8;
};

/// Derivatives of a scalar by what the first particle brings to its contacts.
template <class T>
struct ParticleContactGradient {
  Vec3<T> x = Vec3<T>::Zero(), v = Vec3<T>::Zero();
  T mass = 0, stiffness = 0;
};

/// J [N s] on the first particle in a step of dt.
template <class T>
Vec3<T> contact_impulse(const ContactPair<T>& p, T dt, T friction) {
  const Vec3<T> apart = p.x[0] - p.x[1];
  const T distance = apart.norm(), depth = p.reach - distance;
  if (!(depth > T(0)) || !(distance > T(0))) return Vec3<T>::Zero();
  const Vec3<T> n = apart / distance, relative = p.v[0] - p.v[1], t = relative - relative.dot(n) * n;
  const T k = p.stiffness[0] * p.stiffness[1] / (p.stiffness[0] + p.stiffness[1]);
  const T push = 2 * dt * k * depth * depth / p.reach;
  const T sliding = t.norm(), reduced = p.mass[0] * p.mass[1] / (p.mass[0] + p.mass[1]);
  const T most = reduced / ContactPair<T>::kStickSteps;
  const T drag = friction * push < most * sliding ? friction * push / sliding : friction > T(0) ? most : T(0);
  return push * n - drag * t;
}

/// From adj_J adds the derivatives by what the first particle is; those by the second follow with both exchanged, as J
/// does, and -adj_J.
template <class T>
void contact_impulse_adjoint(const ContactPair<T>& p, T dt, T friction, const Vec3<T>& adj_J,
                             ParticleContactGradient<T>& by) {
  const Vec3<T> apart = p.x[0] - p.x[1];
  const T distance = apart.norm(), depth = p.reach - distance;
  if (!(depth > T(0)) || !(distance > T(0))) return;
  const Vec3<T> n = apart / distance, relative = p.v[0] - p.v[1], t = relative - relative.dot(n) * n;
  const T both = p.stiffness[0] + p.stiffness[1], k = p.stiffness[0] * p.stiffness[1] / both;
  const T rate = 2 * dt * depth / p.reach, push = rate * k * depth;
  const T sliding = t.norm(), total = p.mass[0] + p.mass[1], reduced = p.mass[0] * p.mass[1] / total;
  const T most = reduced / ContactPair<T>::kStickSteps;
  const bool slides = friction * push < most * sliding;
  const T drag = slides ? friction * push / sliding : friction > T(0) ? most : T(0);
  T adj_push = adj_J.dot(n);
  Vec3<T> adj_n = push * adj_J, adj_t = -drag * adj_J;
  const T adj_drag = -adj_J.dot(t);
  if (slides) {
    adj_push += adj_drag * friction / sliding;
    adj_t -= adj_drag * drag / (sliding * sliding) * t;
  } else if (friction > T(0)) {
    by.mass += adj_drag / ContactPair<T>::kStickSteps * p.mass[1] * p.mass[1] / (total * total);
  }
  // t = u - (u . n) n
  by.v += adj_t - adj_t.dot(n) * n;
  adj_n -= adj_t.dot(n) * relative + relative.dot(n) * adj_t;
  by.x += (adj_n - adj_n.dot(n) * n) / distance - 2 * adj_push * rate * k * n;
  by.stiffness += adj_push * rate * depth * p.stiffness[1] * p.stiffness[1] / (both * both);
}

}  // namespace pliant
