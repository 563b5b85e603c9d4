#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "app/demo/kinds/paint.h"
#include "app/demo/kinds/shapes.h"
#include "gaussians/base/random.h"
#include "physics/loads/region.h"

namespace pliant {

constexpr double kDegree = std::numbers::pi / 180;

/// Isotropic elastic solid [Pa, -, kg/m^3].
struct ElasticSolid {
  double young = 0, poisson = 0, density = 0;
};

/// What some parts of an object are made of.
struct DemoMaterial {
  std::string name;  ///< of the parts: "stem"
  ElasticSolid solid;
  ElasticSolid low, high;  ///< band from which a seed draws `solid`
  std::string reason;      ///< why that band, a sentence
  bool fixed = false;      ///< stands still and has no elasticity: a pot, a stand
};

/// A painted solid in the frame of its object.
struct DemoPiece {
  int material = 0;  ///< index into DemoObject::materials
  std::shared_ptr<const AnalyticShape> shape;
  Eigen::Isometry3d object_from_local = Eigen::Isometry3d::Identity();
  Paint paint = {};

  bool contains(const Vec3d& x) const;
};

/// An object whose shape, look, material and support are known.  Its frame: origin on the table, z up, the front looks
/// to -y; metres.
struct DemoObject {
  std::string name;
  std::vector<DemoMaterial> materials;  ///< fixed ones first; the first that moves carries the others
  std::vector<DemoPiece> pieces;        ///< where several overlap, the first one's material holds
  std::vector<Region> pins;             ///< spheres, cylinders, and boxes around something round about z
  Vec3d tip = Vec3d::Zero();            ///< place that is followed, and pushed
  double tip_radius = 0;                ///< of what is pushed
  Vec3d push = Vec3d::UnitX();          ///< unit; pushes and winds go this way
  Vec3d pull = Vec3d::UnitX();          ///< unit; the way that a hand pulls
  std::optional<Region> jolted = {};    ///< what a jolt pushes, of the shapes of pins; none: the box around what moves,
                                        ///< which holds what is pinned in its middle, too
  double height = 0, reach = 0;         ///< top, and largest distance from the axis; see measure()
  double view = 1;                      ///< how far cameras are, over the usual distance

  bool moves(const DemoPiece& piece) const { return !materials[piece.material].fixed; }
  int main_material() const;  ///< the first that moves
  /// Index of the material at x among what moves, -1 elsewhere.
  int material_at(const Vec3d& x) const;
  /// Sets height and reach from the surfaces.
  void measure();
};

/// Where an object stands: on the table near the middle, turned a little about z.
Eigen::Isometry3d place_object(Random& random);
/// A pose that stands at a place of the table, turned about z.
Eigen::Isometry3d standing(double x, double y, double z, double turn);

/// The pose whose axes are x, y and x cross y; both are unit and at right angles.
Eigen::Isometry3d frame(const Vec3d& origin, const Vec3d& x, const Vec3d& y);

/// Solid points with the material of each; every point stands for cell^3.
struct ObjectSolid {
  std::vector<Vec3d> position;  ///< frame of the object
  std::vector<int> material;
  double cell = 0;  ///< [m]
  double volume() const { return static_cast<double>(position.size()) * cell * cell * cell; }
};

/// Jittered points, one per cell of a regular grid between the heights `lowest` and `height` and up to `reach` from the
/// axis, wherever `material_at` is not negative.
ObjectSolid sample_solid(double reach, double height, double cell, double lowest, uint64_t seed,
                         const std::function<int(const Vec3d&)>& material_at);
/// About `count` points in everything of the object that moves.
ObjectSolid sample_object(const DemoObject& object, int count, uint64_t seed);

}  // namespace pliant
