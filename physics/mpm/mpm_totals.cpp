#include <Eigen/Geometry>
#include <cmath>

#include "gaussians/base/error.h"
#include "physics/mpm/mpm.h"
#include "physics/mpm/rest_stencil.h"

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;

}  // namespace

template <class T>
ParticlePlace<double> Mpm<T>::place_of(int particle) const {
  const int s = data_.slot[particle];
  const ParticleRecord<T>& r = data_.record[s];
  if (!options_.lagrangian) return {Vec3d(r.x[0], r.x[1], r.x[2]), Vec3d(r.v[0], r.v[1], r.v[2])};
  const ParticlePlace<T> place = pliant::place_of(data_, s, data_.node_displacement, data_.node_velocity);
  return {place.x.template cast<double>(), place.v.template cast<double>()};
}

template <class T>
typename Mpm<T>::Motion Mpm<T>::motion_of(std::span<const int> particles) const {
  Motion motion;
  for (const int i : particles) {
    const ParticlePlace<double> place = place_of(i);
    const double m = rest_[i].mass;
    motion.mass += m;
    motion.centre += m * place.x;
    motion.velocity += m * place.v;
  }
  if (motion.mass > 0) {
    motion.centre /= motion.mass;
    motion.velocity /= motion.mass;
  }
  return motion;
}

template <class T>
double Mpm<T>::inertia_of(std::span<const int> particles, const Vec3d& centre, const Vec3d& axis) const {
  double sum = 0;
  for (const int i : particles) {
    const Vec3d arm = place_of(i).x - centre;
    sum += rest_[i].mass * (arm.squaredNorm() - std::pow(arm.dot(axis), 2));
  }
  return sum;
}

template <class T>
Totals Mpm<T>::grid_totals(bool velocities) const {
  Totals totals;
  for (int n = 0; n < data_.grid.node_blocks(); ++n) {
    const BlockGrid::Coordinates& block = data_.grid.node_block(n);
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      const size_t at = static_cast<size_t>(n) * BlockGrid::kNodes + k;
      const bool lagrangian = options_.lagrangian;
      const T *node = data_.node[at].lane, *moving = lagrangian ? data_.node_velocity[at].lane : node;
      const double mass = moving[3];
      Vec3d x = data_.origin.template cast<double>() + double(data_.dx) * Vec3d(kSide * block.x + k / (kSide * kSide),
                                                                                kSide * block.y + k / kSide % kSide,
                                                                                kSide * block.z + k % kSide);
      if (lagrangian) x += three(data_.node_displacement[at]).template cast<double>();
      Vec3d momentum = Vec3d(moving[0], moving[1], moving[2]) * (velocities || lagrangian ? mass : 1.0);
      if (!velocities && lagrangian) momentum += Vec3d(node[0], node[1], node[2]);
      totals.mass += mass;
      totals.momentum += momentum;
      totals.angular += x.cross(momentum);
    }
  }
  return totals;
}

template <class T>
Totals Mpm<T>::particle_totals() const {
  CHECK_MSG(!options_.lagrangian, "the motion of a Lagrangian run is that of the nodes");
  Totals totals;
  for (const ParticleRecord<T>& r : data_.record) {
    const double m = r.mass, inertia = 0.25 * m * data_.dx * data_.dx;
    const Vec3d x(r.x[0], r.x[1], r.x[2]), v(r.v[0], r.v[1], r.v[2]);
    totals.mass += m;
    totals.momentum += m * v;
    totals.angular += m * x.cross(v);
    totals.angular += inertia * Vec3d(r.C[7] - r.C[5], r.C[2] - r.C[6], r.C[3] - r.C[1]);
  }
  return totals;
}

template <class T>
typename Mpm<T>::NodeEnergy Mpm<T>::node_energy() const {
  NodeEnergy energy;
  const std::vector<Node<T>> stiffness = sum_over_particles(
      data_, [&](int s, T w, const Vec3<T>&, T* lane) { lane[0] += w * data_.rest[s].stabilization; });
  for (size_t i = 0; i < data_.node_velocity.size(); ++i) {
    const Node<T>& v = data_.node_velocity[i];
    energy.kinetic += 0.5 * v.lane[3] * static_cast<double>(three(v).squaredNorm());
    energy.stabilization +=
        0.5 * stiffness[i].lane[0] * static_cast<double>(three(data_.node_displacement[i]).squaredNorm());
  }
  // Less the affine part, to which the rest is orthogonal under the weights.
  const double scale = 2.0 * data_.inverse_dx;
  for (size_t s = 0; s < data_.record.size(); ++s) {
    const AtParticle<T> u = at_particle(data_, static_cast<int>(s), data_.node_displacement);
    energy.stabilization -= 0.5 * data_.rest[s].stabilization *
                            static_cast<double>(u.value.squaredNorm() + scale * scale * u.moment.squaredNorm());
  }
  return energy;
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
