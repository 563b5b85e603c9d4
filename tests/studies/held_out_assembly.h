#pragma once

// How the held-out objects are put together: rods, sheets and solids, and samples spread over them.

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <numeric>

#include "fitting/distribution/material_object.h"
#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant::study {

struct Material {
  double young, poisson, density;
};

inline Material scaled(Material m, double by) {
  m.young *= by;
  return m;
}

struct Look {
  Vec3d colour;
  Material material;
};

struct Point {
  Vec3d position;
  double thickness;  // of the sheet or rod, 0 = thick
  double content;    // m^3 for each m^dimension of the piece
  Look look;
};

inline double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

inline Vec3d blend(const Vec3d& a, const Vec3d& b, double t) { return (1 - t) * a + t * b; }
inline double blend_log(double a, double b, double t) { return std::exp((1 - t) * std::log(a) + t * std::log(b)); }
inline double log_uniform(Random& random, double low, double high) { return blend_log(low, high, random.uniform()); }
inline double factor(Random& random, double decades) { return std::pow(10, decades * random.normal()); }
inline Vec3d tint(Random& random, const Vec3d& colour, double sigma) {
  const double brightness = 1 + sigma * random.normal();
  const Vec3d shift{random.normal(), random.normal(), random.normal()};  // braces keep the order of the calls
  return brightness * colour + 0.5 * sigma * shift;
}

struct Frame {
  Vec3d origin, x, y, z;
  Vec3d at(const Vec3d& p) const { return origin + p.x() * x + p.y() * y + p.z() * z; }
};

/// A frame whose z points along `z` and whose x lies as near to `x` as that allows.
inline Frame frame_along(const Vec3d& origin, const Vec3d& z, const Vec3d& x) {
  const Vec3d axis = z.normalized();
  const Vec3d side = (x - axis * axis.dot(x) + 1e-9 * axis.unitOrthogonal()).normalized();
  return {origin, side, axis.cross(side), axis};
}

/// A polyline of equal steps, with s in 0..1.
struct Curve {
  std::vector<Vec3d> points;

  Vec3d at(double s) const {
    const double t = std::clamp(s, 0.0, 1.0) * (points.size() - 1.0);
    const size_t i = std::min(static_cast<size_t>(t), points.size() - 2);
    return blend(points[i], points[i + 1], t - i);
  }
  Vec3d direction(double s) const { return (at(std::min(s, 0.98) + 0.02) - at(std::min(s, 0.98))).normalized(); }
  double length() const {
    double sum = 0;
    for (size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
    return sum;
  }
};

inline Curve straight(const Vec3d& from, const Vec3d& to) { return {{from, to}}; }

/// Collects the pieces of an object and spreads samples over them.
class Assembly {
 public:
  Assembly(std::string family, uint64_t seed) : random(seed), seed_(seed) { object_.family = std::move(family); }

  Random random;

  /// look(s, rho): s along the rod, rho from the axis in radii; some samples per cell show what lies across it.
  void add_rod(int part, const Curve& curve, const std::function<double(double)>& radius,
               const std::function<Look(double, double)>& look, int per_cell = 3) {
    const double length = curve.length();
    double volume = 0;
    for (int i = 0; i < 64; ++i) volume += length / 64 * M_PI * std::pow(radius((i + 0.5) / 64), 2);
    pieces_.push_back(
        {part, 1, per_cell, length, volume, [=](Random& r) {
           const double s = r.uniform(), rho = std::sqrt(r.uniform()), angle = r.uniform(0, 2 * M_PI);
           const Frame f = frame_along(curve.at(s), curve.direction(s), Vec3d(0.3, 0.5, 0.2));
           const double a = radius(s);
           return Point{f.at(a * rho * Vec3d(std::cos(angle), std::sin(angle), 0)), 2 * a, M_PI * a * a, look(s, rho)};
         }});
  }

  /// A sheet x(u, v) over the unit square.
  void add_sheet(int part, const std::function<Vec3d(double, double)>& x,
                 const std::function<double(double, double)>& thickness,
                 const std::function<Look(double, double)>& look) {
    constexpr int kGrid = 24;
    std::vector<double> sums;  // of the areas of cells so far
    double area = 0, volume = 0;
    for (int i = 0; i < kGrid * kGrid; ++i) {
      const double u = (i / kGrid + 0.5) / kGrid, v = (i % kGrid + 0.5) / kGrid, e = 0.5 / kGrid;
      const double cell = (x(u + e, v) - x(u - e, v)).cross(x(u, v + e) - x(u, v - e)).norm();
      sums.push_back(area += cell);
      volume += cell * thickness(u, v);
    }
    pieces_.push_back({part, 2, 1, area, volume, [=](Random& r) {
                         const auto it = std::upper_bound(sums.begin(), sums.end(), area * r.uniform());
                         const int i = std::min(static_cast<int>(it - sums.begin()), kGrid * kGrid - 1);
                         const double u = (i / kGrid + r.uniform()) / kGrid, v = (i % kGrid + r.uniform()) / kGrid;
                         const double t = thickness(u, v);
                         return Point{x(u, v), t, t, look(u, v)};
                       }});
  }

  /// What of the box low..high of a frame is inside.
  void add_solid(int part, const Frame& frame, const Vec3d& low, const Vec3d& high,
                 const std::function<bool(const Vec3d&)>& inside, const std::function<Look(const Vec3d&)>& look) {
    const auto propose = [=](Random& r) {
      return Vec3d{r.uniform(low.x(), high.x()), r.uniform(low.y(), high.y()), r.uniform(low.z(), high.z())};
    };
    constexpr int kTries = 20000;
    int hits = 0;
    for (int i = 0; i < kTries; ++i) hits += inside(propose(random));
    CHECK(hits > 0);
    const double volume = (high - low).prod() * hits / kTries;
    pieces_.push_back({part, 3, 1, volume, volume, [=](Random& r) {
                         Vec3d p = propose(r);
                         while (!inside(p)) p = propose(r);
                         return Point{frame.at(p), 0, 1, look(p)};
                       }});
  }

  /// Each cell of side h of a thick part, of a sheet or of a rod holds its number of samples; h follows from their sum.
  MaterialObject finish(int samples) {
    const auto count = [](const Piece& p, double h) {
      const double cells = std::max(p.volume / (h * h * h), p.extent / std::pow(h, p.dimension));
      return std::max(1l, std::lround(p.per_cell * cells));
    };
    double low = 1e-5, high = 1;
    for (int i = 0; i < 60; ++i) {
      const double h = std::sqrt(low * high);
      long n = 0;
      for (const Piece& p : pieces_) n += count(p, h);
      (n > samples ? low : high) = h;
    }
    for (size_t k = 0; k < pieces_.size(); ++k) spread(pieces_[k], count(pieces_[k], high), Random(seed_, k + 1));
    SolidSamples& out = object_.samples;
    const double total = std::accumulate(out.volume.begin(), out.volume.end(), 0.0);
    out.spacing = static_cast<float>(std::cbrt(total / static_cast<double>(out.size())));
    return std::move(object_);
  }

 private:
  struct Piece {
    int part, dimension;  // 1 = rod, 2 = sheet, 3 = thick
    int per_cell;
    double extent, volume;  // m^dimension, m^3
    std::function<Point(Random&)> draw;
  };

  /// Samples one by one, each the farthest from those before it of some candidates (Mitchell 1991).
  void spread(const Piece& piece, long n, Random r) {
    constexpr int kCandidates = 8;
    std::vector<Vec3d> placed;
    for (long i = 0; i < n; ++i) {
      Point best{};
      double farthest = -1;
      for (int c = 0; c < kCandidates; ++c) {
        const Point p = piece.draw(r);
        double nearest = INFINITY;
        for (const Vec3d& other : placed) nearest = std::min(nearest, (p.position - other).squaredNorm());
        if (nearest <= farthest) continue;
        farthest = nearest;
        best = p;
      }
      placed.push_back(best.position);
      const Material& m = best.look.material;
      object_.samples.position.push_back(best.position.cast<float>());
      object_.samples.volume.push_back(static_cast<float>(piece.extent / n * best.content));
      object_.samples.thickness.push_back(static_cast<float>(best.thickness));
      object_.colour.push_back(tint(r, best.look.colour, 0.04).cast<float>().cwiseMax(0.0f).cwiseMin(1.0f));
      object_.part.push_back(piece.part);
      object_.young.push_back(static_cast<float>(m.young * factor(r, 0.04)));
      object_.poisson.push_back(static_cast<float>(m.poisson));
      object_.density.push_back(static_cast<float>(m.density * (1 + 0.02 * r.normal())));
    }
  }

  uint64_t seed_;
  std::vector<Piece> pieces_;
  MaterialObject object_;
};

}  // namespace pliant::study
