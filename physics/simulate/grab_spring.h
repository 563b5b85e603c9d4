#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

#include "physics/mpm/particles.h"
#include "physics/simulate/interaction.h"

namespace pliant {

/// Part of [t, t + dt] that lies in [start, end].
inline double overlap(double t, double dt, double start, double end) {
  return std::clamp((std::min(t + dt, end) - std::max(t, start)) / dt, 0.0, 1.0);
}

/// Point of a path at a time since its start; linear in between, constant outside.
inline Vec3d path_position(const std::vector<Interaction::PathPoint>& path, double time) {
  const auto next = std::upper_bound(path.begin(), path.end(), time,
                                     [](double t, const Interaction::PathPoint& point) { return t < point.time; });
  if (next == path.begin()) return path.front().position;
  if (next == path.end()) return path.back().position;
  const auto last = next - 1;
  const double s = (time - last->time) / (next->time - last->time);
  return last->position + s * (next->position - last->position);
}

/// Length [m] of the uniform bar whose volume lies as far from its centre, along its axis, as that of these particles
/// along their longest: sqrt(12 variance).  Each particle counts as a cube.
template <class T>
double bar_length(const BasicParticles<T>& particles, std::span<const int> touched) {
  double volume = 0, own = 0;
  Vec3d centre = Vec3d::Zero();
  for (const int i : touched) {
    const double v = particles.volume[i];
    volume += v;
    own += v * std::cbrt(v * v) / 12;
    centre += v * particles.position[i].template cast<double>();
  }
  centre /= volume;
  Mat3d variance = own * Mat3d::Identity();
  for (const int i : touched) {
    const Vec3d r = particles.position[i].template cast<double>() - centre;
    variance += static_cast<double>(particles.volume[i]) * r * r.transpose();
  }
  return std::sqrt(12 * Eigen::SelfAdjointEigenSolver<Mat3d>(variance / volume).eigenvalues()[2]);
}

/// The damped spring of a grab during the substep [t, t + dt], which gives no more than so many newtons.
struct GrabSpring {
  static constexpr double kFrequency = 10;   ///< Hz, of the body's mass on the default spring
  static constexpr double kMaxStrain = 0.5;  ///< of a bar of the touched material under the default largest force
  static constexpr double kOmega = 2 * 3.14159265358979324 * kFrequency;

  double dt, stiffness, damping, max_force;
  Vec3d target, target_velocity;

  GrabSpring(const Interaction& it, double body_mass, double newtons, double t, double step)
      : dt(step),
        stiffness(it.stiffness > 0 ? it.stiffness : kOmega * kOmega * body_mass),
        damping(it.damping > 0 ? it.damping : 2 * std::sqrt(stiffness * body_mass)),
        max_force(newtons),
        target(path_position(it.path, t + dt - it.start)),
        target_velocity((target - path_position(it.path, t - it.start)) / dt) {}

  /// Implicit in the velocity of the touched mass, so that the spring does not limit the time step.
  double denominator(double mass) const { return 1 + dt * (damping + dt * stiffness) / mass; }
  Vec3d unlimited(const Vec3d& centre, const Vec3d& velocity, double mass) const {
    return (stiffness * (target - centre - dt * velocity) + damping * (target_velocity - velocity)) / denominator(mass);
  }
  Vec3d force(const Vec3d& unlimited) const {
    const double newtons = unlimited.norm();
    return newtons > max_force ? Vec3d(unlimited * (max_force / newtons)) : unlimited;
  }
};

}  // namespace pliant
