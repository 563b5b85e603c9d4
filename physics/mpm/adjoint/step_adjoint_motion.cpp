// The common motion of some particles, on which grabs and torques depend, and the way back to these particles.

#include <span>

#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {

template <class T>
ParticlePlace<double> StepAdjoint<T>::place_of(const TapeStep<T>& step, int i) const {
  if (step.lagrangian()) {
    const ParticlePlace<T> p = pliant::place_of(solver_, solver_.slot[i], step.node_displacement, step.node_velocity);
    return {p.x.template cast<double>(), p.v.template cast<double>()};
  }
  const TapeParticle<T>& p = step.particle[place_[i]];
  return {Vec3d(p.x[0], p.x[1], p.x[2]), Vec3d(p.v[0], p.v[1], p.v[2])};
}

/// The record of a particle, derivatives by whose motion will be added to it.
template <class T>
AdjointRecord<T>& StepAdjoint<T>::followed_record(int i) {
  if (!followed_.empty()) followed_[solver_.block_of_slot[solver_.slot[i]]] = 1;
  return record_[slot_[i]];
}

template <class T>
typename StepAdjoint<T>::Motion StepAdjoint<T>::motion_of(const TapeStep<T>& step, std::span<const int> particles) {
  place_.resize(record_.size());
  for (size_t s = 0; s < step.index.size(); ++s) place_[step.index[s]] = static_cast<int>(s);
  Motion motion;
  for (const int i : particles) {
    const ParticlePlace<double> p = place_of(step, i);
    const double m = record_[slot_[i]].mass;
    motion.mass += m;
    motion.centre += m * p.x;
    motion.velocity += m * p.v;
  }
  motion.centre /= motion.mass;
  motion.velocity /= motion.mass;
  return motion;
}

template <class T>
void StepAdjoint<T>::motion_adjoint(const TapeStep<T>& step, std::span<const int> particles, const Motion& motion,
                                    const Vec3d& by_centre, const Vec3d& by_velocity) {
  for (const int i : particles) {
    const ParticlePlace<double> p = place_of(step, i);
    AdjointRecord<T>& r = followed_record(i);
    const double share = r.mass / motion.mass;
    double by_mass = 0;
    for (int a = 0; a < 3; ++a) {
      r.x[a] += static_cast<T>(share * by_centre[a]);
      r.v[a] += static_cast<T>(share * by_velocity[a]);
      by_mass += by_centre[a] * (p.x[a] - motion.centre[a]) + by_velocity[a] * (p.v[a] - motion.velocity[a]);
    }
    r.by_mass += static_cast<T>(by_mass / motion.mass);
  }
}

template <class T>
Mat3d StepAdjoint<T>::inertia_of(const TapeStep<T>& step, std::span<const int> particles, const Vec3d& centre) const {
  Mat3d sum = Mat3d::Zero();
  for (const int i : particles) {
    const Vec3d arm = place_of(step, i).x - centre;
    sum += record_[slot_[i]].mass * (arm.squaredNorm() * Mat3d::Identity() - arm * arm.transpose());
  }
  return sum;
}

template <class T>
void StepAdjoint<T>::inertia_adjoint(const TapeStep<T>& step, std::span<const int> particles, const Vec3d& centre,
                                     const Mat3d& by_inertia) {
  // A : sum m (r^2 - r r^T) = sum m r^T B r, B = tr A - A; about the centre of mass the centre does not change it.
  const Mat3d B = by_inertia.trace() * Mat3d::Identity() - by_inertia, both = B + B.transpose();
  for (const int i : particles) {
    AdjointRecord<T>& r = followed_record(i);
    const Vec3d arm = place_of(step, i).x - centre, by_arm = both * arm;
    for (int a = 0; a < 3; ++a) r.x[a] += static_cast<T>(r.mass * by_arm[a]);
    r.by_mass += static_cast<T>(0.5 * arm.dot(by_arm));
  }
}

template class StepAdjoint<float>;
template class StepAdjoint<double>;

}  // namespace pliant
