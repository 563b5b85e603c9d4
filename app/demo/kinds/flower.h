#pragma once

#include <cstdint>

#include "app/demo/kinds/object.h"

namespace pliant {

/// Materials of the flower's object.
enum FlowerPart : int { kPot = 0, kStem = 1, kLeaf = 2, kBlossom = 3 };

/// A potted flower whose proportions make it resolvable with few particles: all lengths follow the diameter of the
/// stem's tip.  Everything below `pin_height` is rigid.
struct Flower {
  double tip_diameter = 0, base_diameter = 0;  ///< of the stem, at its free end and at the pinned plane [m]
  double free_length = 0;                      ///< of the stem above the pinned plane [m]
  double pin_height = 0, soil_height = 0;      ///< above the table [m]
  double pot_radius = 0;                       ///< largest [m]
  Vec3d leaf_semi_axes = Vec3d::Zero();        ///< along, across, half thickness [m]
  Vec3d blossom_centre = Vec3d::Zero();
  DemoObject object;

  const ElasticSolid& solid(int part) const { return object.materials[part].solid; }
};

/// The flower of a seed, with Young's moduli chosen so that the stem with rigid riders swings at
/// 2.2 Hz; the whole, whose leaves bend too, then swings near 1.9 Hz.
Flower make_flower(uint64_t seed);

/// Points in the stem, the leaves and the blossom above z = lowest.
ObjectSolid sample_flower(const Flower& flower, double cell, double lowest, uint64_t seed);

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
