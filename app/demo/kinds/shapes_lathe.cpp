#include <algorithm>
#include <cmath>
#include <utility>

#include "app/demo/kinds/rows.h"
#include "app/demo/kinds/shapes.h"

namespace pliant {
namespace {

using Eigen::Vector2d;

class LatheSurface final : public AnalyticShape {
 public:
  explicit LatheSurface(std::vector<Vector2d> profile) : profile_(std::move(profile)) {
    double low = kNoHit, high = -kNoHit;
    for (const Vector2d& p : profile_) {
      low = std::min(low, p.y());
      high = std::max(high, p.y());
    }
    centre_ = Vec3d(0, 0, 0.5 * (low + high));
    for (const Vector2d& p : profile_) radius_ = std::max(radius_, std::hypot(p.x(), p.y() - centre_.z()));
  }

  SurfaceHit intersect(const Ray& ray, double t_min, double t_max) const override {
    SurfaceHit best;
    best.t = t_max;
    bool found = false;
    for (size_t s = 0; s + 1 < profile_.size(); ++s) {
      double roots[2];
      const int count = crossings(s, ray, roots);
      for (int i = 0; i < count; ++i) {
        if (!(roots[i] > t_min && roots[i] < best.t)) continue;
        best.t = roots[i];
        found = true;
        const Vec3d x = ray.origin + best.t * ray.direction;
        best.normal = around(outward(s), std::atan2(x.y(), x.x()));
      }
    }
    return found ? best : SurfaceHit{};
  }
  // Inside the outer wall: the first part of the profile, along which z rises.
  bool inside(const Vec3d& x) const override {
    for (size_t s = 0; s + 1 < profile_.size(); ++s) {
      const Vector2d a = profile_[s], b = profile_[s + 1];
      if (b.y() <= a.y()) break;
      if (x.z() < a.y() || x.z() > b.y()) continue;
      return std::hypot(x.x(), x.y()) <= a.x() + (b.x() - a.x()) * (x.z() - a.y()) / (b.y() - a.y());
    }
    return false;
  }
  std::vector<SurfacePoint> cover(double spacing, uint64_t seed) const override {
    std::vector<SurfacePoint> points;
    for (size_t s = 0; s + 1 < profile_.size(); ++s) {
      const Vector2d a = profile_[s], b = profile_[s + 1];
      // Rows at equal shares of the length; a short segment gets one row with fewer points.
      const double length = (b - a).norm();
      const int rows = steps(length, spacing);
      const double thin = std::min(1.0, length / spacing);
      cover_rows(
          rows, seed, s + 1,
          [&](double row) { return steps(kTwoPi * (a.x() + row * (b.x() - a.x())) * thin, spacing); },
          [&](double row, double column) { points.push_back(at(s, row, kTwoPi * column)); });
    }
    return points;
  }
  TriangleMesh mesh(double spacing) const override {
    TriangleMesh mesh;
    const int columns = std::max(8, steps(kTwoPi * radius_max(), spacing));
    int rows = 0;
    for (size_t s = 0; s + 1 < profile_.size(); ++s) {
      const int pieces = steps((profile_[s + 1] - profile_[s]).norm(), spacing);
      const int last = s + 2 == profile_.size() ? pieces : pieces - 1;
      for (int r = 0; r <= last; ++r, ++rows)
        for (int c = 0; c < columns; ++c) {
          const SurfacePoint p = at(s, static_cast<double>(r) / pieces, kTwoPi * c / columns);
          mesh.vertex.push_back(p.position);
          mesh.normal.push_back(p.normal);
        }
    }
    connect_rows(mesh, rows, columns);
    return mesh;
  }
  Vec3d bound_centre() const override { return centre_; }
  double bound_radius() const override { return radius_; }

 private:
  static Vec3d around(const Vector2d& rz, double angle) {
    return {rz.x() * std::cos(angle), rz.x() * std::sin(angle), rz.y()};
  }
  Vector2d outward(size_t s) const {
    const Vector2d along = profile_[s + 1] - profile_[s];
    return Vector2d(along.y(), -along.x()).normalized();
  }
  SurfacePoint at(size_t s, double share, double angle) const {
    return {around(profile_[s] + share * (profile_[s + 1] - profile_[s]), angle), around(outward(s), angle)};
  }
  double radius_max() const {
    double r = 0;
    for (const Vector2d& p : profile_) r = std::max(r, p.x());
    return r;
  }

  /// Ray parameters at which the ray crosses the band of segment s: a ring in a plane, or a cone
  /// x^2 + y^2 = (r0 + k (z - z0))^2 between two heights.
  int crossings(size_t s, const Ray& ray, double (&roots)[2]) const {
    const Vector2d a = profile_[s], b = profile_[s + 1];
    const Vec3d &o = ray.origin, &d = ray.direction;
    if (std::abs(b.y() - a.y()) < 1e-12) {
      if (d.z() == 0) return 0;
      const double t = (a.y() - o.z()) / d.z(), r = std::hypot(o.x() + t * d.x(), o.y() + t * d.y());
      roots[0] = t;
      return r >= std::min(a.x(), b.x()) && r <= std::max(a.x(), b.x()) ? 1 : 0;
    }
    const double k = (b.x() - a.x()) / (b.y() - a.y()), r = a.x() + k * (o.z() - a.y());
    const double qa = d.x() * d.x() + d.y() * d.y() - k * k * d.z() * d.z();
    const double qb = o.x() * d.x() + o.y() * d.y() - k * d.z() * r, qc = o.x() * o.x() + o.y() * o.y() - r * r;
    const double under = qb * qb - qa * qc;
    if (under < 0 || std::abs(qa) < 1e-14) return 0;
    int count = 0;
    for (const double sign : {-1.0, 1.0}) {
      const double t = (-qb + sign * std::sqrt(under)) / qa, z = o.z() + t * d.z();
      const bool in_band = z >= std::min(a.y(), b.y()) && z <= std::max(a.y(), b.y());
      if (in_band && r + k * t * d.z() >= 0) roots[count++] = t;
    }
    return count;
  }

  std::vector<Vector2d> profile_;
  Vec3d centre_;
  double radius_ = 0;
};

}  // namespace

std::unique_ptr<AnalyticShape> make_lathe(const std::vector<Eigen::Vector2d>& profile) {
  return std::make_unique<LatheSurface>(profile);
}

}  // namespace pliant
