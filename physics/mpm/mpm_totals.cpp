#include <Eigen/Geometry>
#include <cmath>

#include "physics/mpm/mpm.h"

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;

}  // namespace

template <class T>
typename Mpm<T>::Motion Mpm<T>::motion_of(std::span<const int> particles) const {
  Motion motion;
  for (const int i : particles) {
    const ParticleRecord<T>& r = data_.record[data_.slot[i]];
    const double m = r.mass;
    motion.mass += m;
    motion.centre += m * Vec3d(r.x[0], r.x[1], r.x[2]);
    motion.velocity += m * Vec3d(r.v[0], r.v[1], r.v[2]);
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
    const ParticleRecord<T>& r = data_.record[data_.slot[i]];
    const Vec3d arm = Vec3d(r.x[0], r.x[1], r.x[2]) - centre;
    sum += r.mass * (arm.squaredNorm() - std::pow(arm.dot(axis), 2));
  }
  return sum;
}

template <class T>
Totals Mpm<T>::grid_totals(bool velocities) const {
  Totals totals;
  for (int n = 0; n < data_.grid.node_blocks(); ++n) {
    const BlockGrid::Coordinates& block = data_.grid.node_block(n);
    for (int k = 0; k < BlockGrid::kNodes; ++k) {
      const Node<T>& node = data_.node[static_cast<size_t>(n) * BlockGrid::kNodes + k];
      const double mass = node.lane[3];
      Vec3d x = data_.origin.template cast<double>() + double(data_.dx) * Vec3d(kSide * block.x + k / (kSide * kSide),
                                                                                kSide * block.y + k / kSide % kSide,
                                                                                kSide * block.z + k % kSide);
      if (options_.lagrangian)
        x += data_.node_displacement[static_cast<size_t>(n) * BlockGrid::kNodes + k].template cast<double>();
      const Vec3d momentum = Vec3d(node.lane[0], node.lane[1], node.lane[2]) * (velocities ? mass : 1.0);
      totals.mass += mass;
      totals.momentum += momentum;
      totals.angular += x.cross(momentum);
    }
  }
  return totals;
}

template <class T>
Totals Mpm<T>::particle_totals() const {
  Totals totals;
  for (const ParticleRecord<T>& r : data_.record) {
    const double m = r.mass, inertia = 0.25 * m * data_.dx * data_.dx;
    const Vec3d x(r.x[0], r.x[1], r.x[2]), v(r.v[0], r.v[1], r.v[2]);
    totals.mass += m;
    totals.momentum += m * v;
    totals.angular += m * x.cross(v);
    if (!options_.lagrangian) {
      totals.angular += inertia * Vec3d(r.C[7] - r.C[5], r.C[2] - r.C[6], r.C[3] - r.C[1]);
      continue;
    }
    // Arms are F d, velocities C d.
    for (int k = 0; k < 3; ++k)
      totals.angular += inertia * Vec3d(r.F[k], r.F[3 + k], r.F[6 + k]).cross(Vec3d(r.C[k], r.C[3 + k], r.C[6 + k]));
  }
  return totals;
}

template <class T>
typename Mpm<T>::NodeEnergy Mpm<T>::node_energy() const {
  NodeEnergy energy;
  for (size_t i = 0; i < data_.node_velocity.size(); ++i) {
    energy.kinetic += 0.5 * data_.node[i].lane[3] * static_cast<double>(data_.node_velocity[i].squaredNorm());
    energy.stabilization +=
        0.5 * data_.node_stabilization[i] * static_cast<double>(data_.node_displacement[i].squaredNorm());
  }
  // The affine part, to which the rest is orthogonal under the weights.
  for (size_t s = 0; s < data_.record.size(); ++s) {
    const ParticleRecord<T>& r = data_.record[s];
    const T* start = data_.undisplaced.data() + 12 * s;
    double square = 0;
    for (int a = 0; a < 3; ++a) square += std::pow(static_cast<double>(r.x[a]) - start[a], 2);
    for (int k = 0; k < 9; ++k)
      square += 0.25 * data_.dx * data_.dx * std::pow(static_cast<double>(r.F[k]) - start[3 + k], 2);
    energy.stabilization -= 0.5 * data_.rest_place[4 * s + 3] * square;
  }
  return energy;
}

template class Mpm<float>;
template class Mpm<double>;

}  // namespace pliant
