#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "app/demo/shapes.h"

namespace pliant {

enum class FlowerPart : uint8_t { kNone = 0, kPot = 1, kStem = 2, kLeaf = 3, kBlossom = 4 };

/// A shape placed in the frame of the flower: origin on the table under the pot, z up, the blossom looks to -y.
struct FlowerPiece {
  FlowerPart part = FlowerPart::kNone;
  std::shared_ptr<const AnalyticShape> shape;
  Eigen::Isometry3d flower_from_local = Eigen::Isometry3d::Identity();
  int tone = 0;                  ///< which of the part's colours
  Vec3d centre = Vec3d::Zero();  ///< of the ball around it, frame of the flower
  double radius = 0;

  bool contains(const Vec3d& x) const {
    return (x - centre).squaredNorm() <= radius * radius && shape->inside(flower_from_local.inverse() * x);
  }
};

/// Isotropic elastic solid [Pa, -, kg/m^3].
struct ElasticSolid {
  double young = 0, poisson = 0, density = 0;
};

/// Solid points of what moves, with the part that each belongs to; every point stands for cell^3.
struct FlowerSolid {
  std::vector<Vec3d> position;  ///< frame of the flower
  std::vector<FlowerPart> part;
  double cell = 0;  ///< [m]
  double volume() const { return static_cast<double>(position.size()) * cell * cell * cell; }
};

/// A potted flower whose proportions make it resolvable with few particles: all lengths follow the diameter of the
/// stem's tip.  Everything below `pin_height` is rigid.
struct Flower {
  double tip_diameter = 0, base_diameter = 0;    ///< of the stem, at its free end and at the pinned plane [m]
  double free_length = 0;                        ///< of the stem above the pinned plane [m]
  double pin_height = 0, soil_height = 0;        ///< above the table [m]
  double pot_radius = 0, height = 0, reach = 0;  ///< largest radius of the pot, top of the blossom, horizontal extent
  Vec3d leaf_semi_axes = Vec3d::Zero();          ///< along, across, half thickness [m]
  Vec3d blossom_centre = Vec3d::Zero();
  std::vector<FlowerPiece> pieces;
  ElasticSolid stem, leaf, blossom;

  const ElasticSolid& solid(FlowerPart part) const {
    return part == FlowerPart::kStem ? stem : part == FlowerPart::kLeaf ? leaf : blossom;
  }
  /// Part of the moving solid at x; kNone outside, in the pot and in the soil around the stem.
  FlowerPart part_at(const Vec3d& x) const;
};

/// The flower of a seed, with Young's moduli chosen so that the stem with rigid riders swings at
/// 2.2 Hz; the whole, whose leaves bend too, then swings near 1.9 Hz.
Flower make_flower(uint64_t seed);

/// Jittered points, one per cell of a regular grid, in the stem, the leaves and the blossom above z = lowest.
FlowerSolid sample_flower(const Flower& flower, double cell, double lowest, uint64_t seed);

/// What the proportions promise to a simulation with N driving particles on a grid of spacing (8 V / N)^(1/3), where
/// V is the solid above the plane three cells below the pinned one.
struct FlowerMechanics {
  double volume = 0;                ///< V [m^3] at 8000 particles
  double cell_8k = 0, cell_4k = 0;  ///< grid spacing [m]
  double stem_cells = 0;            ///< thinnest diameter of the stem in cells, 8000 particles
  double leaf_cells = 0;            ///< thickness of a leaf at its middle in cells, 8000 particles
  double frequency = 0;    ///< bending mode of the stem that carries rigid leaves and blossom [Hz], Rayleigh quotient
  double substeps_4k = 0;  ///< per 1/30 s frame at dt = 0.4 dx / c, 4000 particles
  double contrast = 0;     ///< Young's modulus of the stem over the next stiffest part
  double compliance = 0;   ///< static deflection of the blossom per horizontal force there [m/N]
};
FlowerMechanics flower_mechanics(const Flower& flower);

}  // namespace pliant
