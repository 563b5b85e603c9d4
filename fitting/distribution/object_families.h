#pragma once

#include <string>
#include <vector>

#include "fitting/distribution/object_builder.h"

namespace pliant {

/// Shapes are kept in single precision.
inline float metres(double length) { return static_cast<float>(length); }

enum class FamilyRole { kTrain, kValidate, kTest };

/// A kind of procedural object.
struct ObjectFamily {
  std::string name;
  FamilyRole role;
  void (*make)(ObjectBuilder& builder);
};

// What the fields rest on.  None of them was measured on an object as a whole; ranges of materials are those of the
// works named, how a field varies over an object is argued in its family, and every factor is drawn anew per object.
// Wood along the grain 5-15 GPa, green less: Wood Handbook, FPL-GTR-190 (2010).  Stems of herbs 10 MPa to some GPa,
// parenchyma under turgor 1-20 MPa, supporting tissue stiffer, so that stems stiffen toward base and rim: Niklas, Plant
// Biomechanics (1992).  Leaves: tens of MPa for the blade, veins several times that: Onoda et al., Ecology Letters 14
// (2011).  Petals, blossoms, flesh of mushrooms and fruit, fur, plush: estimates.  Foams: E falls with the square of
// relative density, Gibson and Ashby, Cellular Solids (1997); they also have bread and cork.  Glass 60-75 GPa, fired
// clay 10-70 GPa, metals 70-210 GPa, thermoplastics 0.2-4 GPa, rubbers 0.5-20 MPa, leather 20-300 MPa, paper and card
// 0.5-5 GPa, soil under a light load 1-50 MPa: Ashby, Materials Selection in Mechanical Design (2011).

std::vector<ObjectFamily> plant_families();   ///< stems, leaves, flesh that grows
std::vector<ObjectFamily> vessel_families();  ///< walls with or without something inside
std::vector<ObjectFamily> soft_families();    ///< cloth, foam, crumb
std::vector<ObjectFamily> made_families();    ///< furniture, lamps, books
std::vector<ObjectFamily> mixed_families();   ///< toys, tools, baskets, whatever stands together: hard and soft parts

/// Substances that several families share, drawn from their ranges.
Substance wood(ObjectBuilder& b);
Substance hard_ware(ObjectBuilder& b);  ///< fired clay, glass, stone
Substance plastic(ObjectBuilder& b);
Substance metal(ObjectBuilder& b);
Substance foam(ObjectBuilder& b);
Substance cloth(ObjectBuilder& b);
Substance soil(ObjectBuilder& b);
/// `s` with its E times `factor`.
Substance stiffer(Substance s, double factor);

/// A pot of that radius and height with soil up to 85 % of it; both are parts of their own.  Returns the soil's height.
float add_pot(ObjectBuilder& b, float radius, float height);

/// How the tissues of one plant differ.
struct PlantTissue {
  double base = 1e8, tip_share = 0.3;  ///< E at the foot of the stem; at its end, as a share of that
  double rim = 1.5;                    ///< E of the stem's outside over that of its middle
  double leaf = 2e7, vein = 5;         ///< E of the blade, and the midrib's factor
  double petal = 1e6, head = 4e6;      ///< E of petals and of the disc that they stand on
  double moist = 950;                  ///< density of stem
  Vec3f green = Vec3f(0.3f, 0.5f, 0.2f), bark = Vec3f(0.35f, 0.45f, 0.2f);
};
PlantTissue herb(ObjectBuilder& b);
PlantTissue woody(ObjectBuilder& b);

/// Stems grow from their first radius to their last; `start` and `end` are the shares of the way from foot to tip that
/// the piece covers, which set its stiffness.
void add_stem(ObjectBuilder& b, const PlantTissue& t, int part, const std::vector<Vec3f>& chain, float first,
              float last, double start = 0, double end = 1);
/// A leaf with a midrib, from `root` outward.
void add_leaf(ObjectBuilder& b, const PlantTissue& t, int part, const Vec3f& root, const Vec3f& direction, float length,
              float width, float thickness);
/// A blossom that faces `axis`: `petals` around a disc.
void add_blossom(ObjectBuilder& b, const PlantTissue& t, int petal_part, int head_part, const Vec3f& centre,
                 const Vec3f& axis, float radius, int petals, const Vec3f& colour);

}  // namespace pliant
