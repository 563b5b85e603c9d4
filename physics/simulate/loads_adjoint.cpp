#include <cmath>

#include "gaussians/base/error.h"
#include "physics/simulate/grab_spring.h"
#include "physics/simulate/inertia.h"
#include "physics/simulate/loads.h"
#include "physics/simulate/weights.h"

namespace pliant {

template <class T>
void LoadSchedule<T>::at_adjoint(double t, double dt, const TapeStep<T>& step, const StepLoadsGradient& by,
                                 StepAdjoint<T>& particles, LoadsGradient& gradient) const {
  const double middle = t + 0.5 * dt;
  Vec3d* gravity = &gradient.gravity;
  size_t next = 0;  // load of the step, in the order in which `at` adds them
  for (size_t k = 0; k < entries_.size(); ++k) {
    const Entry& entry = entries_[k];
    const Interaction& it = entry.interaction;
    const double part = overlap(t, dt, it.start, entry.end);
    const bool active = middle >= it.start && middle < entry.end;
    // An acceleration factor / M * vector of the touched mass M.
    const auto force = [&](double factor) {
      const Vec3d& a = by.body[next++].acceleration;
      gradient.vector[k] += factor / entry.mass * a;
      gradient.touched_mass[k] -= factor / (entry.mass * entry.mass) * a.dot(it.vector);
    };
    switch (it.type) {
      case InteractionType::kGravity:
        if (active) gravity = &gradient.vector[k];
        break;
      case InteractionType::kPointForce:
        if (part > 0) force(part);
        break;
      case InteractionType::kImpulse:
        if (starts_within(it.start, t, dt)) force(1 / dt);
        break;
      case InteractionType::kGrab:
        if (active) grab_adjoint(entry, t, dt, step, by.body[next++].acceleration, particles, k, gradient);
        break;
      case InteractionType::kGust:
        if (part > 0) {
          const double factor = it.rate > 0 ? part * it.rate / (1 + part * dt * it.rate) : part;
          gradient.vector[k] += factor * by.body[next++].acceleration;
        }
        break;
      case InteractionType::kPin:
        if (active && entry.sprung) ++next;
        break;
      case InteractionType::kGround:
      case InteractionType::kCollider:
      case InteractionType::kPoke:
        break;
      case InteractionType::kTorque:
        if (part > 0) torque_adjoint(entry, part, step, by.body[next++], particles, gradient.vector[k]);
        break;
      case InteractionType::kWind:
        if (part > 0) gradient.vector[k] += by.body[next++].wind;
        break;
      case InteractionType::kWeight:
        if (cancels_gravity(middle)) {
          const Vec3d& force = by.body[next++].per_volume;
          gradient.gravity += it.mass / entry.volume * force;
          gradient.weight[k] += force.dot(options_.gravity) / entry.volume;
        }
        break;
    }
  }
  CHECK(next == by.body.size());
  if (gradient.density.size() < by.density.size()) gradient.density.resize(by.density.size());
  for (size_t o = 0; o < by.density.size(); ++o) gradient.density[o] += by.density[o];
  *gravity += by.gravity;
  if (cancels_gravity(middle)) gradient.gravity -= by.gravity;
  if (options_.damping_time > 0)
    gradient.damping_time += by.velocity_scale * std::exp(-2 * dt / options_.damping_time) * 2 * dt /
                             (options_.damping_time * options_.damping_time);
}

template <class T>
void LoadSchedule<T>::grab_adjoint(const Entry& entry, double t, double dt, const TapeStep<T>& step,
                                   const Vec3d& by_acceleration, StepAdjoint<T>& particles, size_t number,
                                   LoadsGradient& gradient) const {
  const Interaction& it = entry.interaction;
  const GrabSpring spring(it, body_mass_, entry.max_force, t, dt);
  const auto motion = particles.motion_of(step, entry.touched);
  const double M = entry.mass, D = spring.denominator(M);
  const Vec3d pull = spring.target - motion.centre - dt * motion.velocity;
  const Vec3d slip = spring.target_velocity - motion.velocity;
  const Vec3d unlimited = spring.unlimited(motion.centre, motion.velocity, M), force = spring.force(unlimited);

  // acceleration = force / M
  Vec3d by_force = by_acceleration / M;
  double by_M = -by_acceleration.dot(force) / (M * M);
  // force = unlimited, cut to the largest one along itself
  if (const double newtons = unlimited.norm(); newtons > spring.max_force) {
    const Vec3d n = unlimited / newtons;
    if (!(it.max_force > 0)) gradient.max_force[number] += by_force.dot(n);
    by_force = spring.max_force / newtons * (by_force - by_force.dot(n) * n);
  }
  // unlimited = (stiffness pull + damping slip) / D, D = 1 + dt (damping + dt stiffness) / M
  const Vec3d by_sum = by_force / D;
  const double by_D = -by_force.dot(unlimited) / D;
  double by_stiffness = by_sum.dot(pull) + by_D * dt * dt / M;
  const double by_damping = by_sum.dot(slip) + by_D * dt / M;
  by_M -= by_D * (D - 1) / M;
  if (!(it.damping > 0)) {
    by_stiffness += by_damping * std::sqrt(body_mass_ / spring.stiffness);
    gradient.body_mass += by_damping * std::sqrt(spring.stiffness / body_mass_);
  }
  if (!(it.stiffness > 0)) gradient.body_mass += by_stiffness * GrabSpring::kOmega * GrabSpring::kOmega;
  gradient.touched_mass[number] += by_M;
  particles.motion_adjoint(step, entry.touched, motion, -spring.stiffness * by_sum,
                           -(spring.stiffness * dt + spring.damping) * by_sum);
}

template <class T>
void LoadSchedule<T>::torque_adjoint(const Entry& entry, double part, const TapeStep<T>& step,
                                     const BodyLoadGradient& by_load, StepAdjoint<T>& particles,
                                     Vec3d& by_torque) const {
  if (entry.touched.size() < 2) return;  // nothing turns a single particle
  const auto motion = particles.motion_of(step, entry.touched);
  const Mat3d inertia = particles.inertia_of(step, entry.touched, motion.centre);
  Mat3d by_inertia = Mat3d::Zero();
  angular_acceleration_adjoint(inertia, entry.interaction.vector, part * by_load.angular, by_inertia, by_torque);
  particles.inertia_adjoint(step, entry.touched, motion.centre, by_inertia);
  particles.motion_adjoint(step, entry.touched, motion, by_load.centre, Vec3d::Zero());
}

template <class T>
std::vector<double> LoadSchedule<T>::add_by_mass(const BasicParticles<T>& particles, const LoadsGradient& gradient,
                                                 std::vector<T>& by_mass) const {
  for (size_t i = 0; i < by_mass.size(); ++i) {
    double sum = gradient.body_mass;
    for (size_t k = 0; k < entries_.size(); ++k)
      if (entries_[k].bit & bits_[i]) sum += gradient.touched_mass[k];
    by_mass[i] += static_cast<T>(sum);
  }
  std::vector<Interaction> interactions;
  for (const Entry& entry : entries_) interactions.push_back(entry.interaction);
  std::vector<double> by_weight = weights_adjoint(particles, interactions, by_mass);
  for (size_t k = 0; k < by_weight.size(); ++k) by_weight[k] += gradient.weight[k];
  // The density is that of the bodies without the weights.
  for (size_t i = 0; i < by_mass.size(); ++i) {
    const size_t object = particles.object.empty() ? 0 : particles.object[i];
    if (object < gradient.density.size() && volume_[object] > 0)
      by_mass[i] += static_cast<T>(gradient.density[object] / volume_[object]);
  }
  return by_weight;
}

template <class T>
void LoadSchedule<T>::add_by_young(const BasicParticles<T>& particles, const LoadsGradient& gradient,
                                   std::vector<T>& by_young) const {
  for (size_t k = 0; k < entries_.size(); ++k)
    if (gradient.max_force[k] != 0)
      for (const int i : entries_[k].touched)
        by_young[i] +=
            static_cast<T>(GrabSpring::kMaxStrain * gradient.max_force[k] * particles.volume[i] / entries_[k].length);
}

template class LoadSchedule<float>;
template class LoadSchedule<double>;

}  // namespace pliant
