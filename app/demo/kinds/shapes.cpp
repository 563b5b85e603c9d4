#include "app/demo/kinds/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/demo/kinds/rows.h"

namespace pliant {
namespace {

class EllipsoidSurface final : public AnalyticShape {
 public:
  explicit EllipsoidSurface(const Vec3d& semi) : semi_(semi) {}

  SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const override {
    const Vec3d o = ray.origin.cwiseQuotient(semi_), d = ray.direction.cwiseQuotient(semi_);
    const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - 1, under = b * b - a * c;
    if (under < 0) return {};
    const double root = std::sqrt(under);
    for (const double t : {(-b - root) / a, (-b + root) / a})
      if (t > t_min && t < t_max) return {t, normal(ray.origin + t * ray.direction)};
    return {};
  }
  bool inside(const Vec3d& x) const override { return x.cwiseQuotient(semi_).squaredNorm() <= 1; }

  // Rings around the longest direction x, at equal steps of arc length along the mean meridian.
  std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const override {
    const std::vector<double> meridian = meridian_angles(256);
    std::vector<SurfacePoint> points;
    auto angle_at = [&](double row) {
      const double at = row * (meridian.size() - 1);
      const size_t i = std::min(static_cast<size_t>(at), meridian.size() - 2);
      return meridian[i] + (at - i) * (meridian[i + 1] - meridian[i]);
    };
    cover_rows(
        steps(meridian_length(), spacing), seed, 1,
        [&](double row) { return steps(kTwoPi * 0.5 * (semi_.y() + semi_.z()) * std::sin(angle_at(row)), spacing); },
        [&](double row, double column) { points.push_back(at(angle_at(row), kTwoPi * column)); });
    return points;
  }
  TriangleMesh mesh(double spacing) const override {
    const int rows = steps(meridian_length(), spacing) + 1,
              columns = std::max(8, steps(kTwoPi * semi_.tail<2>().maxCoeff(), spacing));
    TriangleMesh mesh;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) {
        const SurfacePoint p = at(std::numbers::pi * r / (rows - 1), kTwoPi * c / columns);
        mesh.vertex.push_back(p.position);
        mesh.normal.push_back(p.normal);
      }
    connect_rows(mesh, rows, columns);
    return mesh;
  }
  Vec3d bound_centre() const override { return Vec3d::Zero(); }
  double bound_radius() const override { return semi_.maxCoeff(); }

 private:
  Vec3d normal(const Vec3d& x) const { return x.cwiseQuotient(semi_).cwiseQuotient(semi_).normalized(); }
  SurfacePoint at(double polar, double around) const {
    const Vec3d u(std::cos(polar), std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around));
    const Vec3d x = semi_.cwiseProduct(u);
    return {x, normal(x)};
  }
  double meridian_step(double polar) const {
    return std::hypot(semi_.x() * std::sin(polar), 0.5 * (semi_.y() + semi_.z()) * std::cos(polar));
  }
  double meridian_length() const {
    double length = 0;
    for (int i = 0; i < 256; ++i) length += meridian_step((i + 0.5) * std::numbers::pi / 256) * std::numbers::pi / 256;
    return length;
  }
  std::vector<double> meridian_angles(int n) const {
    std::vector<double> angle = {0};
    const double target = meridian_length() / n;
    double covered = 0;
    const int fine = 16 * n;
    for (int i = 0; i < fine; ++i) {
      covered += meridian_step((i + 0.5) * std::numbers::pi / fine) * std::numbers::pi / fine;
      if (covered >= target * static_cast<double>(angle.size())) angle.push_back((i + 1) * std::numbers::pi / fine);
    }
    angle.push_back(std::numbers::pi);
    return angle;
  }

  Vec3d semi_;
};

class CuboidSurface final : public AnalyticShape {
 public:
  explicit CuboidSurface(const Vec3d& half) : half_(half) {}

  SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const override {
    double enter = -kNoHit, leave = kNoHit;
    int enter_axis = 0, leave_axis = 0;
    for (int k = 0; k < 3; ++k) {
      if (ray.direction[k] == 0) {
        if (std::abs(ray.origin[k]) > half_[k]) return {};
        continue;
      }
      const double a = (-half_[k] - ray.origin[k]) / ray.direction[k],
                   b = (half_[k] - ray.origin[k]) / ray.direction[k];
      if (std::min(a, b) > enter) {
        enter = std::min(a, b);
        enter_axis = k;
      }
      if (std::max(a, b) < leave) {
        leave = std::max(a, b);
        leave_axis = k;
      }
    }
    if (enter > leave) return {};
    const bool from_inside = enter <= t_min;
    const double t = from_inside ? leave : enter;
    if (t <= t_min || t >= t_max) return {};
    const int axis = from_inside ? leave_axis : enter_axis;
    Vec3d normal = Vec3d::Zero();
    normal[axis] = (ray.direction[axis] > 0) == from_inside ? 1 : -1;
    return {t, normal};
  }
  bool inside(const Vec3d& x) const override { return (x.cwiseAbs().array() <= half_.array()).all(); }
  std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const override {
    std::vector<SurfacePoint> points;
    for (int face = 0; face < 6; ++face) {
      const int k = face / 2, i = (k + 1) % 3, j = (k + 2) % 3;
      cover_rows(
          steps(2 * half_[i], spacing), seed, static_cast<uint64_t>(face + 1),
          [&](double) { return steps(2 * half_[j], spacing); },
          [&](double row, double column) {
            SurfacePoint p{Vec3d::Zero(), Vec3d::Zero()};
            p.normal[k] = face % 2 ? -1 : 1;
            p.position[k] = half_[k] * p.normal[k];
            p.position[i] = half_[i] * (2 * row - 1);
            p.position[j] = half_[j] * (2 * column - 1);
            points.push_back(p);
          });
    }
    return points;
  }
  Vec3d bound_centre() const override { return Vec3d::Zero(); }
  double bound_radius() const override { return half_.norm(); }

 private:
  Vec3d half_;
};

class Handle final : public AnalyticShape {
 public:
  Handle(double ring, double tube) : ring_(ring), tube_(tube) {}

  // The distance to a torus is exact, so the ray advances by it (Hart 1996), inside the half space x >= 0.
  SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const override {
    double begin = t_min, end = t_max;
    if (ray.direction.x() != 0) {
      const double wall = -ray.origin.x() / ray.direction.x();
      ray.direction.x() > 0 ? begin = std::max(begin, wall) : end = std::min(end, wall);
    } else if (ray.origin.x() < 0) {
      return {};
    }
    double t = begin + 1e-9;
    const double side = signed_distance(ray.origin + t * ray.direction) < 0 ? -1 : 1;
    for (int i = 0; i < 128 && t < end; ++i) {
      const Vec3d x = ray.origin + t * ray.direction;
      const double distance = side * signed_distance(x);
      if (distance < 1e-7) return {t, normal(x)};
      if (distance > 2 * (ring_ + tube_) && x.dot(ray.direction) > 0) break;
      t += distance;
    }
    return {};
  }
  bool inside(const Vec3d& x) const override { return x.x() >= 0 && signed_distance(x) <= 0; }
  std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const override {
    std::vector<SurfacePoint> points;
    cover_rows(
        steps(std::numbers::pi * ring_, spacing), seed, 1, [&](double) { return steps(kTwoPi * tube_, spacing); },
        [&](double row, double column) {
          const double along = std::numbers::pi * (row - 0.5), turn = kTwoPi * column;
          const Vec3d radial(std::cos(along), 0, std::sin(along));
          const Vec3d n = std::cos(turn) * radial + std::sin(turn) * Vec3d::UnitY();
          points.push_back({ring_ * radial + tube_ * n, n});
        });
    return points;
  }
  Vec3d bound_centre() const override { return Vec3d::Zero(); }
  double bound_radius() const override { return ring_ + tube_; }

 private:
  double signed_distance(const Vec3d& x) const { return std::hypot(std::hypot(x.x(), x.z()) - ring_, x.y()) - tube_; }
  Vec3d normal(const Vec3d& x) const {
    const Vec3d radial = Vec3d(x.x(), 0, x.z()).normalized();
    return (x - ring_ * radial).normalized();
  }

  double ring_, tube_;
};

}  // namespace

std::unique_ptr<AnalyticShape> make_ellipsoid(const Vec3d& semi_axes) {
  return std::make_unique<EllipsoidSurface>(semi_axes);
}
std::unique_ptr<AnalyticShape> make_cuboid(const Vec3d& half) { return std::make_unique<CuboidSurface>(half); }
std::unique_ptr<AnalyticShape> make_handle(double ring_radius, double tube_radius) {
  return std::make_unique<Handle>(ring_radius, tube_radius);
}

}  // namespace pliant
