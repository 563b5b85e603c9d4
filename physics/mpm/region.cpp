#include "physics/mpm/region.h"

#include <algorithm>
#include <limits>

namespace pliant {

Region Region::sphere(const Vec3d& centre, double radius) {
  Region r;
  r.kind = Kind::kSphere, r.point = centre, r.radius = radius;
  return r;
}

Region Region::box(const Vec3d& low, const Vec3d& high) {
  Region r;
  r.kind = Kind::kBox, r.point = low, r.vector = high;
  return r;
}

Region Region::half_space(const Vec3d& point, const Vec3d& normal) {
  Region r;
  r.kind = Kind::kHalfSpace, r.point = point, r.vector = normal.normalized();
  return r;
}

double Region::signed_distance(const Vec3d& x) const {
  switch (kind) {
    case Kind::kAll: return -std::numeric_limits<double>::infinity();
    case Kind::kSphere: return (x - point).norm() - radius;
    case Kind::kBox: {
      const Vec3d out = (point - x).cwiseMax(x - vector);
      return out.cwiseMax(0.0).norm() + std::min(out.maxCoeff(), 0.0);
    }
    case Kind::kHalfSpace: return (x - point).dot(vector);
  }
  return std::numeric_limits<double>::infinity();
}

Region Region::scaled(double factor) const {
  Region r = *this;
  r.point *= factor;
  if (kind == Kind::kBox) r.vector *= factor;
  r.radius *= factor;
  return r;
}

}  // namespace pliant
