#include "app/demo/kinds/kind_builder.h"

#include <algorithm>
#include <cmath>

#include "app/demo/kinds/pot.h"
#include "app/demo/kinds/rows.h"
#include "fitting/distribution/shapes.h"

namespace pliant {
namespace {

constexpr double kTurnedEdge = 0.0018;  // m, of the triangles
constexpr double kUsualHeight = 0.35;   // m, of an object that is seen from the usual distance

uint64_t stream_of(const std::string& name) {
  uint64_t hash = 1469598103934665603ull;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<uint8_t>(c)) * 1099511628211ull;
  return hash;
}

}  // namespace

KindBuilder::KindBuilder(const std::string& name, uint64_t seed) : seed_(seed), random_(seed, stream_of(name)) {
  object.name = name;
}

int KindBuilder::material(const std::string& name, const ElasticSolid& low, const ElasticSolid& high,
                          const std::string& reason) {
  DemoMaterial m{name, {}, low, high, reason, false};
  m.solid.young = std::exp(between(std::log(low.young), std::log(high.young)));
  m.solid.poisson = between(low.poisson, high.poisson);
  m.solid.density = between(low.density, high.density);
  object.materials.push_back(m);
  return static_cast<int>(object.materials.size()) - 1;
}

int KindBuilder::fixed(const std::string& name) {
  DemoMaterial m;
  m.name = name;
  m.fixed = true;
  object.materials.push_back(m);
  return static_cast<int>(object.materials.size()) - 1;
}

Paint KindBuilder::paint(Paint::Kind kind, const Vec3d& albedo, const Vec3d& accent, double period) {
  return {kind, albedo, accent, 0.010, seed_ * 64 + 2 + object.pieces.size(), period};
}

void KindBuilder::add(int material, std::shared_ptr<const AnalyticShape> shape, const Eigen::Isometry3d& pose,
                      const Paint& paint) {
  object.pieces.push_back({material, std::move(shape), pose, paint});
}

double KindBuilder::add_pot(double radius, double height, double stem_radius) {
  const int pot = fixed("pot");
  const double soil = height - 0.010;
  add(pot, make_lathe(pot_profile(radius, height, soil)), paint(colour(kPotColours)));
  add(pot, make_lathe(soil_profile(radius, soil, stem_radius)), paint(kSoilColour));
  const double pin = soil + 0.014, r = radius + 0.01;
  object.pins.push_back(Region::box({-r, -r, -0.01}, {r, r, pin}));
  return pin;
}

DemoObject KindBuilder::finish() {
  object.measure();
  // A small object is seen from nearer.
  object.view = std::clamp(std::max(object.height, 1.8 * object.reach) / kUsualHeight, 0.6, 1.0);
  return std::move(object);
}

std::unique_ptr<AnalyticShape> make_blade(const Blade& blade) {
  Sweep sweep;
  sweep.spine = spine_of(curve(Vec3f::Zero(), Vec3f::UnitX(), static_cast<float>(blade.length), Vec3f::UnitZ(),
                               static_cast<float>(blade.bend)));
  sweep.half = [half = blade.half_width, outline = blade.outline](double u) { return half * outline(u); };
  sweep.half_thickness = blade.half_thickness;
  sweep.lift = blade.lift;
  return make_sweep(sweep);
}

Eigen::Isometry3d blade_pose(const Vec3d& root, const Vec3d& direction, const Vec3d& up) {
  const Vec3d x = direction.normalized();
  return frame(root, x, up.cross(x).normalized());
}

std::unique_ptr<AnalyticShape> make_turned(const std::vector<Eigen::Vector2d>& profile, int flutes, double depth) {
  std::vector<double> at = {0};
  double widest = 0;
  for (size_t i = 1; i < profile.size(); ++i) {
    at.push_back(at.back() + (profile[i] - profile[i - 1]).norm());
    widest = std::max(widest, profile[i].x());
  }
  SurfaceMap map;
  // Rows lie on all corners, so that they stay sharp.
  map.rows = {0};
  for (size_t i = 1; i < profile.size(); ++i) {
    const int n = steps(at[i] - at[i - 1], kTurnedEdge);
    for (int k = 1; k <= n; ++k) map.rows.push_back((at[i - 1] + (at[i] - at[i - 1]) * k / n) / at.back());
  }
  map.rows.back() = 1;
  map.columns = std::max(16, steps(2 * std::numbers::pi * widest, kTurnedEdge));
  map.at = [=](double u, double v) {
    const double s = u * at.back();
    const size_t i = std::clamp<size_t>(std::upper_bound(at.begin(), at.end(), s) - at.begin(), 1, at.size() - 1);
    const double f = std::clamp((s - at[i - 1]) / (at[i] - at[i - 1]), 0.0, 1.0);
    const Eigen::Vector2d p = profile[i - 1] + f * (profile[i] - profile[i - 1]);
    const double angle = 2 * std::numbers::pi * v, r = p.x() * (1 + depth * std::cos(flutes * angle));
    return Vec3d(r * std::cos(angle), r * std::sin(angle), p.y());
  };
  return make_surface(map);
}

Vec3d Stem::at(double share) const {
  const double place = share * static_cast<double>(spine.size() - 1);
  const size_t i = std::min(static_cast<size_t>(place), spine.size() - 2);
  return spine[i] + (place - static_cast<double>(i)) * (spine[i + 1] - spine[i]);
}

Vec3d Stem::direction(double share) const {
  const size_t i = std::min(static_cast<size_t>(share * static_cast<double>(spine.size() - 1)), spine.size() - 2);
  return (spine[i + 1] - spine[i]).normalized();
}

Stem make_stem(const Vec3d& foot, const Vec3d& direction, double length, const Vec3d& pull, double bend) {
  return {spine_of(curve(foot.cast<float>(), direction.cast<float>(), static_cast<float>(length), pull.cast<float>(),
                         static_cast<float>(bend)))};
}

}  // namespace pliant
