#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/demo/kinds/object.h"
#include "app/demo/kinds/sweep.h"
#include "gaussians/base/random.h"

namespace pliant {

/// Puts the pieces of an object of one kind and seed together.
class KindBuilder {
 public:
  /// Every kind draws from a stream of its own.
  KindBuilder(const std::string& name, uint64_t seed);

  double between(double low, double high) { return random_.uniform(low, high); }
  template <size_t N>
  Vec3d colour(const Vec3d (&palette)[N]) {
    return pick_colour(random_, palette);
  }

  /// A material drawn from its band: E log-uniformly, nu and rho uniformly.  Returns its index.
  int material(const std::string& name, const ElasticSolid& low, const ElasticSolid& high, const std::string& reason);
  /// Something that stands still.
  int fixed(const std::string& name);

  Paint paint(Paint::Kind kind, const Vec3d& albedo, const Vec3d& accent, double period = 0.02);
  Paint paint(const Vec3d& albedo) { return paint(Paint::Kind::kPlain, albedo, albedo); }
  void add(int material, std::shared_ptr<const AnalyticShape> shape, const Eigen::Isometry3d& pose, const Paint& paint);
  void add(int material, std::shared_ptr<const AnalyticShape> shape, const Paint& paint) {
    add(material, std::move(shape), Eigen::Isometry3d::Identity(), paint);
  }
  /// A pot with soil around a stem; its plant is pinned up to the height that is returned.
  double add_pot(double radius, double height, double stem_radius);

  DemoObject object;  ///< pins, tip and directions are set by the kind
  DemoObject finish();

 private:
  uint64_t seed_;
  Random random_;
};

/// A leaf, petal or shell in a frame of its own: from the origin along x, turning towards z by `bend` radians, as wide
/// as y.
struct Blade {
  double length = 0, half_width = 0, half_thickness = 0;
  double bend = 0;
  std::function<double(double u)> outline;  ///< share of the half width at the share u of the length
  std::function<double(double u, double across)> lift = {};
};
std::unique_ptr<AnalyticShape> make_blade(const Blade& blade);
/// The pose of a blade that starts at `root` along `direction`; its upper side looks towards `up`.
Eigen::Isometry3d blade_pose(const Vec3d& root, const Vec3d& direction, const Vec3d& up);

/// A solid of revolution about z: the polyline (radius, z) from axis to axis, with `flutes` waves of that share of the
/// radius around it.
std::unique_ptr<AnalyticShape> make_turned(const std::vector<Eigen::Vector2d>& profile, int flutes = 0,
                                           double depth = 0);

/// A stem that leans and bends a little, with its end and the direction there.
struct Stem {
  std::vector<Vec3d> spine;
  Vec3d at(double share) const;
  Vec3d direction(double share) const;
};
Stem make_stem(const Vec3d& foot, const Vec3d& direction, double length, const Vec3d& pull, double bend);

}  // namespace pliant
