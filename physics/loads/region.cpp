#include "physics/loads/region.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// Unit vector along v, or `otherwise` where v has no length.
Vec3d direction(const Vec3d& v, const Vec3d& otherwise) {
  const double length = v.norm();
  return length > 0 ? Vec3d(v / length) : otherwise;
}

/// A point seen in the plane of a cylinder's axis: distances beyond the nearer cap and beyond the mantle.
struct AlongCylinder {
  double beyond_cap, beyond_mantle;
  Vec3d cap_normal, mantle_normal;
};

AlongCylinder along_cylinder(const Region& r, const Vec3d& x) {
  const Vec3d middle = 0.5 * (r.point + r.vector), axis = direction(r.vector - r.point, Vec3d::UnitZ());
  const double height = (x - middle).dot(axis);
  const Vec3d radial = x - middle - height * axis;
  int smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  const Vec3d across = axis.cross(Vec3d::Unit(smallest)).normalized();
  return {std::abs(height) - 0.5 * (r.vector - r.point).norm(), radial.norm() - r.radius,
          height < 0 ? Vec3d(-axis) : axis, direction(radial, across)};
}

}  // namespace

Region Region::sphere(const Vec3d& centre, double radius) {
  Region r;
  r.kind = Kind::kSphere;
  r.point = centre;
  r.radius = radius;
  return r;
}

Region Region::box(const Vec3d& low, const Vec3d& high) {
  Region r;
  r.kind = Kind::kBox;
  r.point = low;
  r.vector = high;
  return r;
}

Region Region::half_space(const Vec3d& point, const Vec3d& normal) {
  Region r;
  r.kind = Kind::kHalfSpace;
  r.point = point;
  r.vector = normal.normalized();
  return r;
}

Region Region::cylinder(const Vec3d& end, const Vec3d& other_end, double radius) {
  Region r;
  r.kind = Kind::kCylinder;
  r.point = end;
  r.vector = other_end;
  r.radius = radius;
  return r;
}

double Region::signed_distance(const Vec3d& x) const {
  switch (kind) {
    case Kind::kAll:
      return -std::numeric_limits<double>::infinity();
    case Kind::kSphere:
      return (x - point).norm() - radius;
    case Kind::kBox: {
      const Vec3d out = (point - x).cwiseMax(x - vector);
      return out.cwiseMax(0.0).norm() + std::min(out.maxCoeff(), 0.0);
    }
    case Kind::kHalfSpace:
      return (x - point).dot(vector);
    case Kind::kCylinder: {
      const AlongCylinder at = along_cylinder(*this, x);
      return std::hypot(std::max(at.beyond_cap, 0.0), std::max(at.beyond_mantle, 0.0)) +
             std::min(std::max(at.beyond_cap, at.beyond_mantle), 0.0);
    }
  }
  return std::numeric_limits<double>::infinity();
}

Vec3d Region::normal(const Vec3d& x) const {
  switch (kind) {
    case Kind::kAll:
      return Vec3d::UnitZ();
    case Kind::kSphere:
      return direction(x - point, Vec3d::UnitZ());
    case Kind::kBox: {
      const Vec3d below = point - x, above = x - vector, out = below.cwiseMax(above);
      Vec3d n = Vec3d::Zero();
      int nearest = 0;
      if (out.maxCoeff(&nearest) <= 0) {  // inside: the nearest face
        n[nearest] = above[nearest] >= below[nearest] ? 1 : -1;
        return n;
      }
      for (int a = 0; a < 3; ++a) n[a] = above[a] > 0 ? above[a] : below[a] > 0 ? -below[a] : 0;
      return n.normalized();
    }
    case Kind::kHalfSpace:
      return vector;
    case Kind::kCylinder: {
      const AlongCylinder at = along_cylinder(*this, x);
      if (at.beyond_cap > 0 && at.beyond_mantle > 0)
        return (at.beyond_cap * at.cap_normal + at.beyond_mantle * at.mantle_normal).normalized();
      return at.beyond_cap > at.beyond_mantle ? at.cap_normal : at.mantle_normal;
    }
  }
  return Vec3d::UnitZ();
}

Vec3d Region::normal_adjoint(const Vec3d& x, const Vec3d& adj_normal) const {
  // Of the direction q / |q|: what of the derivative is across it, over |q|.
  const auto by_vector = [](const Vec3d& adj, const Vec3d& unit, double length) -> Vec3d {
    if (!(length > 0)) return Vec3d::Zero();
    return (adj - adj.dot(unit) * unit) / length;
  };
  switch (kind) {
    case Kind::kAll:
    case Kind::kHalfSpace:
      return Vec3d::Zero();
    case Kind::kSphere:
      return by_vector(adj_normal, normal(x), (x - point).norm());
    case Kind::kBox: {
      // Outside of an edge or corner; a face has the same normal everywhere.
      const Vec3d out = (point - x).cwiseMax(x - vector).cwiseMax(0.0);
      return by_vector(adj_normal, normal(x), out.norm()).cwiseProduct((out.array() > 0).cast<double>().matrix());
    }
    case Kind::kCylinder: {
      const AlongCylinder at = along_cylinder(*this, x);
      const auto by_mantle_normal = [&](const Vec3d& adj) -> Vec3d {
        const Vec3d across = adj - adj.dot(at.cap_normal) * at.cap_normal;
        return by_vector(across, at.mantle_normal, at.beyond_mantle + radius);
      };
      if (at.beyond_cap > 0 && at.beyond_mantle > 0) {
        const Vec3d adj = by_vector(adj_normal, normal(x), std::hypot(at.beyond_cap, at.beyond_mantle));
        return adj.dot(at.cap_normal) * at.cap_normal + adj.dot(at.mantle_normal) * at.mantle_normal +
               at.beyond_mantle * by_mantle_normal(adj);
      }
      return at.beyond_cap > at.beyond_mantle ? Vec3d(Vec3d::Zero()) : by_mantle_normal(adj_normal);
    }
  }
  return Vec3d::Zero();
}

double Region::half_thickness() const {
  if (!bounded()) return std::numeric_limits<double>::infinity();
  if (kind == Kind::kBox) return 0.5 * (vector - point).minCoeff();
  return kind == Kind::kSphere ? radius : std::min(radius, 0.5 * (vector - point).norm());
}

double Region::farthest(const Vec3d& x) const {
  if (!bounded()) return std::numeric_limits<double>::infinity();
  if (kind == Kind::kBox) return (x - point).cwiseAbs().cwiseMax((x - vector).cwiseAbs()).norm();
  if (kind == Kind::kSphere) return (x - point).norm() + radius;
  return std::max((x - point).norm(), (x - vector).norm()) + radius;
}

Region Region::grown(double distance) const {
  Region r = *this;
  switch (kind) {
    case Kind::kAll:
      break;
    case Kind::kSphere:
      r.radius += distance;
      break;
    case Kind::kBox:
      r.point.array() -= distance;
      r.vector.array() += distance;
      break;
    case Kind::kHalfSpace:
      r.point += distance * vector;
      break;
    case Kind::kCylinder: {
      const Vec3d along = distance * direction(vector - point, Vec3d::UnitZ());
      r.point -= along;
      r.vector += along;
      r.radius += distance;
      break;
    }
  }
  return r;
}

Region Region::scaled(double factor) const {
  Region r = *this;
  r.point *= factor;
  if (kind == Kind::kBox || kind == Kind::kCylinder) r.vector *= factor;
  r.radius *= factor;
  return r;
}

}  // namespace pliant
