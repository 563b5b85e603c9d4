#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "gaussians/base/polar.h"

namespace pliant {

/// Acceleration of the particles whose load bits contain `bit`:
///   a + b x (x - centre) - drag v - k (x - reference) + wind,
/// reference = where the particle lay at rest, k = spring (lambda + 2 mu) / (rho dx^2).  The wind presses on the
/// surface elements that face it with pressure |w - v|^2.
template <class T>
struct BodyLoad {
  uint32_t bit = 0;
  Vec3<T> acceleration = Vec3<T>::Zero();  ///< a, m/s^2
  T drag = 0;                              ///< 1/s
  Vec3<T> angular = Vec3<T>::Zero();       ///< b, 1/s^2
  Vec3<T> centre = Vec3<T>::Zero();        ///< m
  T spring = 0;                            ///< no unit
  Vec3<T> wind = Vec3<T>::Zero();          ///< w, m/s
  T pressure = 0;                          ///< kg/m^3, density of the air times drag coefficient / 2
};

/// What a load reads of a particle.
template <class T>
struct LoadedParticle {
  Vec3<T> x, v, reference;
  Mat3<T> F;
  Vec3<T> exposure;  ///< m^2, outward surface element that the particle stands for at rest
  T mass;            ///< kg
  T stiffness;       ///< 1/s^2, (lambda + 2 mu) / (rho dx^2)
};

/// Velocity that the load gives to the particle in a step of dt; wind is implicit in |w - v|.
template <class T>
Vec3<T> velocity_gain(const BodyLoad<T>& load, T dt, const LoadedParticle<T>& p) {
  const Vec3<T> arm = p.x - load.centre;
  Vec3<T> a = load.acceleration - load.drag * p.v - load.spring * p.stiffness * (p.x - p.reference);
  a += Vec3<T>(load.angular[1] * arm[2] - load.angular[2] * arm[1], load.angular[2] * arm[0] - load.angular[0] * arm[2],
               load.angular[0] * arm[1] - load.angular[1] * arm[0]);
  Vec3<T> gain = dt * a;
  if (load.pressure > T(0)) {
    const Vec3<T> u = load.wind - p.v;
    const T against = -(cofactor(p.F) * p.exposure).dot(u);  // area that faces the wind, times |u|
    if (against > T(0)) {
      const T rate = dt * load.pressure * against / p.mass;
      gain += rate / (1 + rate) * u;
    }
  }
  return gain;
}

/// Adds to `adj` (x, v, F) the derivatives of a scalar from that with respect to the gain.
template <class T>
void velocity_gain_adjoint(const BodyLoad<T>& load, T dt, const LoadedParticle<T>& p, const Vec3<T>& adj_gain,
                           Vec3<T>& adj_x, Vec3<T>& adj_v, Mat3<T>& adj_F) {
  const Vec3<T> adj_a = dt * adj_gain;
  adj_v -= load.drag * adj_a;
  adj_x -= load.spring * p.stiffness * adj_a;
  // a = b x r: the transpose of the cross product is the product from the other side.
  adj_x += Vec3<T>(adj_a[1] * load.angular[2] - adj_a[2] * load.angular[1],
                   adj_a[2] * load.angular[0] - adj_a[0] * load.angular[2],
                   adj_a[0] * load.angular[1] - adj_a[1] * load.angular[0]);
  if (!(load.pressure > T(0))) return;
  const Vec3<T> u = load.wind - p.v, element = cofactor(p.F) * p.exposure;
  const T against = -element.dot(u);
  if (!(against > T(0))) return;
  const T c = dt * load.pressure / p.mass, rate = c * against, share = rate / (1 + rate);
  const T adj_against = adj_gain.dot(u) * c / ((1 + rate) * (1 + rate));
  adj_v -= share * adj_gain;            // through u
  adj_v += adj_against * element;       // through the area that faces it
  const Vec3<T> adj_element = -adj_against * u;
  const Vec3<T>& e = p.exposure;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, q = (j + 2) % 3;
      const T w = adj_element[i] * e[j];
      adj_F(a, k) += w * p.F(b, q), adj_F(b, q) += w * p.F(a, k);
      adj_F(a, q) -= w * p.F(b, k), adj_F(b, k) -= w * p.F(a, q);
    }
}

}  // namespace pliant
