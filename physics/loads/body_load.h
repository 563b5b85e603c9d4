#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "gaussians/base/polar.h"

namespace pliant {

/// Acceleration of the particles whose load bits contain `bit`:
///   a + f V / m + b x (x - centre) - drag v - k (x - reference) + wind,
/// V = volume at rest, reference = where the particle lay at rest, k = spring M / (rho dx^2), M = WaveModulus.  The
/// wind presses on the surface elements that face it with pressure |w - v|^2.
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
  Vec3<T> per_volume = Vec3<T>::Zero();    ///< f, N/m^3
};

/// What a load reads of a particle.
template <class T>
struct LoadedParticle {
  Vec3<T> x, v, reference;
  Mat3<T> F;         ///< deformation gradient with the permanent part
  Vec3<T> exposure;  ///< m^2, outward surface element that the particle stands for at rest
  T mass, volume;    ///< kg, m^3 at rest
  T stiffness;       ///< 1/s^2, M / (rho dx^2)
};

/// Whether what the load gives depends on x or F of a particle, or on its v.
template <class T>
bool reads_place(const BodyLoad<T>& load) {
  return load.spring != T(0) || load.pressure > T(0) || !load.angular.isZero();
}
template <class T>
bool reads_motion(const BodyLoad<T>& load) {
  return load.drag != T(0) || load.pressure > T(0);
}

/// Velocity that the load gives to the particle in a step of dt; wind is implicit in |w - v|.
template <class T>
Vec3<T> velocity_gain(const BodyLoad<T>& load, T dt, const LoadedParticle<T>& p) {
  const Vec3<T> arm = p.x - load.centre;
  Vec3<T> a = load.acceleration - load.drag * p.v - load.spring * p.stiffness * (p.x - p.reference);
  a += load.angular.cross(arm) + p.volume / p.mass * load.per_volume;
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

/// Derivatives of a scalar by what a load is made of, and by what it reads of a particle.
struct BodyLoadGradient {
  Vec3d acceleration = Vec3d::Zero(), angular = Vec3d::Zero(), centre = Vec3d::Zero(), wind = Vec3d::Zero(),
        per_volume = Vec3d::Zero();
  double drag = 0;
};
template <class T>
struct LoadedParticleGradient {
  Vec3<T> x = Vec3<T>::Zero(), v = Vec3<T>::Zero();
  Mat3<T> F = Mat3<T>::Zero();
  T mass = 0, stiffness = 0;
};

/// Adds to `by` and `by_load` the derivatives of a scalar from that with respect to the gain.
template <class T>
void velocity_gain_adjoint(const BodyLoad<T>& load, T dt, const LoadedParticle<T>& p, const Vec3<T>& adj_gain,
                           LoadedParticleGradient<T>& by, BodyLoadGradient& by_load) {
  const Vec3<T> adj_a = dt * adj_gain, stretch = p.x - p.reference, arm = p.x - load.centre;
  by_load.acceleration += adj_a.template cast<double>();
  by_load.drag -= static_cast<double>(adj_a.dot(p.v));
  by.v -= load.drag * adj_a;
  by.x -= load.spring * p.stiffness * adj_a;
  by.stiffness -= load.spring * adj_a.dot(stretch);
  // a = b x r: b gets r x adj, r gets adj x b.
  const Vec3<T> adj_arm = adj_a.cross(load.angular);
  by.x += adj_arm;
  by_load.centre -= adj_arm.template cast<double>();
  by_load.angular += arm.cross(adj_a).template cast<double>();
  const Vec3<T> adj_force = p.volume / p.mass * adj_a;
  by_load.per_volume += adj_force.template cast<double>();
  by.mass -= adj_force.dot(load.per_volume) / p.mass;
  if (!(load.pressure > T(0))) return;
  const Vec3<T> u = load.wind - p.v, element = cofactor(p.F) * p.exposure;
  const T against = -element.dot(u);
  if (!(against > T(0))) return;
  const T c = dt * load.pressure / p.mass, rate = c * against, share = rate / (1 + rate);
  const T adj_rate = adj_gain.dot(u) / ((1 + rate) * (1 + rate)), adj_against = adj_rate * c;
  const Vec3<T> adj_u = share * adj_gain - adj_against * element;
  by.v -= adj_u;
  by_load.wind += adj_u.template cast<double>();
  by.mass -= adj_rate * rate / p.mass;
  const Vec3<T> adj_element = -adj_against * u;
  const Vec3<T>& e = p.exposure;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, q = (j + 2) % 3;
      const T w = adj_element[i] * e[j];
      by.F(a, k) += w * p.F(b, q);
      by.F(b, q) += w * p.F(a, k);
      by.F(a, q) -= w * p.F(b, k);
      by.F(b, k) -= w * p.F(a, q);
    }
}

}  // namespace pliant
