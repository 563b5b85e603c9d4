#include <Eigen/Geometry>
#include <cmath>

#include "fitting/distribution/object_families.h"

namespace pliant {
namespace {

/// A round wall on a floor; the profile is that of its outside.
void add_wall(ObjectBuilder& b, int part, float height, float thick, const std::function<float(float)>& outer,
              const Vec3f& colour, const Substance& wall) {
  const float floor = 1.5f * thick / height;
  b.add(Lathe(Vec3f::Zero(), Vec3f::UnitZ(), height, outer,
              [=](float s) { return s < floor ? 0.0f : std::max(outer(s) - thick, 0.3f * outer(s)); }),
        part, colour, wall);
}

/// What stands in it up to the share `full` of the height.  From outside one sees the wall, but for the top.
void add_content(ObjectBuilder& b, int part, float height, float thick, double full,
                 const std::function<float(float)>& outer, const Vec3f& seen, const Vec3f& own, const Substance& s) {
  const float low = 1.5f * thick, high = metres(height * full) - low;
  b.add(
      Lathe({0, 0, low}, Vec3f::UnitZ(), high,
            [=](float a) { return std::max(outer((low + a * high) / height) - thick, 0.3f * thick); }),
      part, [=](const ShapePoint& p) { return (1 - p.along) * high < p.depth || p.along > 0.85f ? own : seen; },
      [s](const ShapePoint&) { return s; });
}

/// Things that fill vessels: gel or wax, earth, grain, food.
Substance content(ObjectBuilder& b) {
  const double kind = b.between(0, 1);
  if (kind < 0.4) return {b.log_between(2e3, 1e5), 0.48, b.between(950, 1100)};
  if (kind < 0.7) return soil(b);
  return {b.log_between(1e5, 1e7), 0.35, b.between(500, 1000)};
}

void make_cup(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.05, 0.16)), radius = height * metres(b.between(0.3, 0.6));
  const float thick = radius * metres(b.between(0.05, 0.14)), flare = metres(b.between(0.6, 1));
  const double kind = b.between(0, 1);
  const Substance card = {b.log_between(5e8, 3e9), 0.3, 700};
  const Substance wall = kind < 0.55 ? hard_ware(b) : kind < 0.85 ? plastic(b) : card;
  const Vec3f colour = b.any_colour();
  const auto outer = [=](float s) { return radius * (flare + (1 - flare) * std::sqrt(s)); };
  const int body = b.new_part(), handle = b.new_part(), inside = b.new_part();
  if (kind < 0.85 && b.chance(0.7)) {
    const float low = 0.25f * height;
    b.add(Tube(curve({0.85f * radius, 0, low}, Vec3f(1, 0, 0.2f), 1.1f * height, Vec3f(-0.3f, 0, 1), 2.9f),
               0.7f * thick, 0.7f * thick),
          handle, colour, wall);
  }
  add_wall(b, body, height, thick, outer, colour, wall);
  if (b.chance(0.5))
    add_content(b, inside, height, thick, b.between(0.3, 0.95), outer, colour, b.any_colour(), content(b));
}

void make_vase(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.1, 0.6)), radius = height * metres(b.between(0.18, 0.4));
  const float thick = radius * metres(b.between(0.05, 0.12)), neck = metres(b.between(0.3, 0.8));
  const auto outer = [=](float s) { return radius * (neck + (1 - neck) * std::sin(3.1415926f * (0.15f + 0.75f * s))); };
  const Substance wall = b.chance(0.8) ? hard_ware(b) : plastic(b);
  const Vec3f colour = b.any_colour();
  const int body = b.new_part(), inside = b.new_part(), twig = b.new_part();
  const PlantTissue t = woody(b);
  for (int k = b.chance(0.5) ? b.count(1, 6) : 0; k > 0; --k) {
    const auto chain = curve({0, 0, 0.1f * height}, b.outward(b.between(0.92, 1)), height * metres(b.between(1.2, 2)),
                             b.outward(0), 0.4f);
    add_stem(b, t, twig, chain, 0.012f * height, 0.004f * height);
  }
  add_wall(b, body, height, thick, outer, colour, wall);
  if (b.chance(0.4))
    add_content(b, inside, height, thick, b.between(0.3, 0.8), outer, colour, b.any_colour(), content(b));
}

void make_bottle(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.1, 0.35)), radius = height * metres(b.between(0.12, 0.25));
  const float thick = radius * metres(b.between(0.03, 0.1)), neck = metres(b.between(0.25, 0.5)),
              shoulder = metres(b.between(0.55, 0.75));
  const auto outer = [=](float s) {
    return s < shoulder ? radius : radius * (neck + (1 - neck) * std::max(0.0f, 1 - (s - shoulder) / 0.2f));
  };
  const bool glass = b.chance(0.5);
  const Substance wall = glass ? Substance{b.log_between(5e10, 7e10), 0.22, 2500} : plastic(b);
  const Substance paper = {b.log_between(5e8, 3e9), 0.3, 800}, cork = {b.log_between(5e6, 3e7), 0.05, 180};
  const Vec3f colour = b.any_colour();
  const int body = b.new_part(), label = b.new_part(), cap = b.new_part(), inside = b.new_part();
  add_wall(b, body, height, thick, outer, colour, wall);
  if (b.chance(0.6))
    add_content(b, inside, height, thick, b.between(0.3, 0.7), outer, colour, b.any_colour(), content(b));
  if (b.chance(0.6))
    b.add(Lathe(
              {0, 0, 0.15f * height}, Vec3f::UnitZ(), 0.3f * height, [=](float) { return 1.02f * radius; },
              [=](float) { return 1.002f * radius; }),
          label, b.any_colour(), paper);
  // Corks and screw caps.
  b.add(Lathe({0, 0, 0.95f * height}, Vec3f::UnitZ(), 0.1f * height, [=](float) { return 1.1f * neck * radius; }), cap,
        b.any_colour(), glass && b.chance(0.6) ? cork : plastic(b));
}

void make_bowl(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.04, 0.15)), radius = height * metres(b.between(1, 2.2)),
              thick = 0.08f * radius;
  const double kind = b.between(0, 1);
  const Substance wall = kind < 0.5 ? hard_ware(b) : kind < 0.75 ? wood(b) : plastic(b);
  const int body = b.new_part(), food = b.new_part();
  const auto outer = [=](float s) { return radius * std::sqrt(0.2f + 0.8f * s); };
  const Vec3f colour = b.any_colour(), other = b.any_colour();
  add_wall(b, body, height, thick, outer, colour, wall);
  // Pieces of one kind heaped up: skins are stiffer than flesh.
  const double young = b.log_between(1e5, 1e7), skin = b.log_between(1, 10);
  for (int k = b.count(0, 9); k > 0; --k) {
    const float r = radius * metres(b.between(0.2, 0.4));
    const Vec3f out = b.outward(0) * radius * metres(b.between(0, 0.6));
    b.add(
        Ellipsoid({out.x(), out.y(), height * metres(b.between(0.5, 1.1))}, Vec3f(r, r, 0.9f * r)), food,
        [c = b.tint(other)](const ShapePoint&) { return c; },
        [=](const ShapePoint& p) {
          return Substance{young * (p.across > 0.9f ? skin : 1), 0.38, 900};
        });
  }
}

void make_shell(ObjectBuilder& b) {
  // Aragonite layers: stiff all through, the lip that grew last and the outer layer a little less so.
  const Substance lime = {b.log_between(2e10, 7e10), 0.25, b.between(2500, 2800)};
  const double lip = b.log_between(0.3, 1), size = b.log_between(0.015, 0.2);
  const int part = b.new_part();
  const Vec3f pale = b.tint({0.85f, 0.75f, 0.65f}, 0.08), band = b.tint({0.6f, 0.4f, 0.3f}, 0.12);
  const float turns = metres(b.between(6, 20));
  const auto look = [=](const ShapePoint& p) {
    return Vec3f(pale + (band - pale) * (0.5f + 0.5f * std::sin(turns * p.along)));
  };
  const auto matter = [=](const ShapePoint& p) { return stiffer(lime, std::pow(lip, p.along)); };
  if (b.chance(0.5)) {  // coiled: a tube that widens
    const int loops = b.count(2, 4);
    std::vector<Vec3f> chain;
    for (int i = 0; i <= 24 * loops; ++i) {
      const float a = 6.2831853f * static_cast<float>(i) / 24,
                  g = std::exp(0.16f * (a - 6.2831853f * static_cast<float>(loops)));
      chain.push_back(metres(size) * g * Vec3f(std::cos(a), std::sin(a), 1.2f));
      chain.back().z() = metres(size) * (2 - 1.2f * g);
    }
    b.add(Tube(chain, metres(0.05 * size), metres(0.5 * size)), part, look, matter);
  } else {  // two valves, or one
    for (int k = b.count(1, 2); k > 0; --k) {
      const Vec3f way = k == 1 ? Vec3f(0.3f, 0, 1) : Vec3f(-0.3f, 0, 1);
      b.add(Sheet(
                curve(Vec3f::Zero(), way, metres(size), Vec3f(0, 0, 1), 0.5f), Vec3f::UnitY(),
                [=](float s) { return metres(size) * 0.6f * std::sqrt(std::max(0.03f, s * (1.5f - s))); },
                metres(b.between(0.2, 0.5)), metres(0.04 * size)),
            part, look, matter);
    }
  }
}

void make_bouquet(ObjectBuilder& b) {
  PlantTissue t = herb(b);
  const float height = metres(b.log_between(0.12, 0.3)), radius = height * metres(b.between(0.25, 0.4)),
              thick = 0.1f * radius;
  const auto outer = [=](float s) { return radius * (0.75f + 0.25f * s); };
  const int stem = b.new_part(), leaf = b.new_part(), petal = b.new_part(), head = b.new_part(), body = b.new_part();
  for (int k = b.count(3, 9); k > 0; --k) {
    t.petal = b.log_between(2e5, 5e6);
    const auto chain = curve({0, 0, 0.1f * height}, b.outward(b.between(0.88, 1)), height * metres(b.between(1.3, 2.2)),
                             b.outward(0), 0.4f);
    add_stem(b, t, stem, chain, 0.02f * height, 0.012f * height);
    add_blossom(b, t, petal, head, chain.back(), (place_on(chain, 1).tangent + b.outward(0.2) * 0.4f).normalized(),
                height * metres(b.between(0.2, 0.5)), b.count(5, 14), b.any_colour());
    for (int i = b.count(0, 3); i > 0; --i)
      add_leaf(b, t, leaf, place_on(chain, metres(b.between(0.5, 0.9))).position, b.outward(0.4), 0.5f * height,
               0.18f * height, 0.003f * height);
  }
  add_wall(b, body, height, thick, outer, b.any_colour(), hard_ware(b));
}

void make_potted_plant(ObjectBuilder& b) {
  const PlantTissue t = b.chance(0.5) ? herb(b) : woody(b);
  const double height = b.log_between(0.1, 0.8);
  const float ground = add_pot(b, metres(height * b.between(0.2, 0.5)), metres(height * b.between(0.25, 0.6)));
  const int stem = b.new_part(), leaf = b.new_part(), petal = b.new_part(), head = b.new_part();
  const double radius = height * b.log_between(0.008, 0.03);
  for (int k = b.count(1, 6); k > 0; --k) {
    const auto chain = curve({0, 0, 0.5f * ground}, b.outward(b.between(0.7, 1)), metres(height * b.between(0.6, 1.1)),
                             b.outward(0), metres(b.between(0, 0.8)));
    add_stem(b, t, stem, chain, metres(radius), metres(0.5 * radius));
    const double length = height * b.between(0.15, 0.4);
    for (int i = b.count(3, 9); i > 0; --i)
      add_leaf(b, t, leaf, place_on(chain, metres(b.between(0.4, 1))).position, b.outward(b.between(0, 0.9)),
               metres(length), metres(length * b.between(0.3, 0.7)), metres(0.0012 * height));
    if (b.chance(0.3))
      add_blossom(b, t, petal, head, chain.back(), b.outward(0.8), metres(0.12 * height), b.count(5, 9),
                  b.any_colour());
  }
}

}  // namespace

std::vector<ObjectFamily> vessel_families() {
  return {{"cup", FamilyRole::kTrain, make_cup},
          {"bottle", FamilyRole::kTrain, make_bottle},
          {"bowl", FamilyRole::kTrain, make_bowl},
          {"shell", FamilyRole::kTrain, make_shell},
          {"potted_plant", FamilyRole::kTrain, make_potted_plant},
          {"vase", FamilyRole::kValidate, make_vase},
          {"bouquet", FamilyRole::kTest, make_bouquet}};
}

}  // namespace pliant
