#include <Eigen/Geometry>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
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
  struct Sums {
    double m = 0;
    Vec3d x = Vec3d::Zero(), v = Vec3d::Zero();
    Mat3d xx = Mat3d::Zero();
    Sums& operator+=(const Sums& other) {
      m += other.m;
      x += other.x;
      v += other.v;
      xx += other.xx;
      return *this;
    }
  };
  Motion motion;
  if (particles.empty()) return motion;
  const Vec3d near = place_of(particles.front()).x;  // moments about a point of the body keep their digits
  const Sums sums = ordered_sum(static_cast<std::ptrdiff_t>(particles.size()), Sums(), [&](std::ptrdiff_t k) {
    const ParticlePlace<double> place = place_of(particles[k]);
    const double m = rest_[particles[k]].mass;
    const Vec3d r = place.x - near;
    return Sums{m, m * r, m * place.v, m * r * r.transpose()};
  });
  motion.mass = sums.m;
  if (motion.mass > 0) {
    const Vec3d mean = sums.x / sums.m;
    motion.centre = near + mean;
    motion.velocity = sums.v / sums.m;
    motion.second = sums.xx - sums.m * mean * mean.transpose();
  }
  return motion;
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
