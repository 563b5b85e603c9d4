#include <Eigen/Geometry>
#include <cmath>

#include "fitting/distribution/object_families.h"

namespace pliant {
namespace {

void make_flower(ObjectBuilder& b) {
  const PlantTissue t = herb(b);
  const int stem = b.new_part(), leaf = b.new_part(), petal = b.new_part(), head = b.new_part();
  const double height = b.log_between(0.1, 0.9), radius = height * b.log_between(0.006, 0.025);
  const Vec3f colour = b.any_colour();
  const auto trunk =
      curve(Vec3f::Zero(), b.outward(b.between(0.9, 1)), metres(height), b.outward(0), metres(b.between(0, 0.6)));
  const double taper = b.between(0.4, 0.9);
  add_stem(b, t, stem, trunk, metres(radius), metres(radius * taper));
  const auto bloom = [&](const std::vector<Vec3f>& chain, double size) {
    const Vec3f axis = place_on(chain, 1).tangent + 0.6f * b.outward(0.2);
    add_blossom(b, t, petal, head, chain.back(), axis.normalized(), metres(size), b.count(4, 18), b.tint(colour, 0.04));
  };
  bloom(trunk, height * b.between(0.07, 0.22));
  for (int k = b.count(0, 4); k > 0; --k) {
    const double at = b.between(0.35, 0.85);
    const auto branch = curve(place_on(trunk, metres(at)).position, b.outward(b.between(0.4, 0.9)),
                              metres(height * b.between(0.15, 0.45)), Vec3f::UnitZ(), metres(b.between(0, 0.6)));
    add_stem(b, t, stem, branch, metres(0.7 * radius), metres(0.7 * radius * taper), at, 1);
    if (b.chance(0.7)) bloom(branch, height * b.between(0.05, 0.15));
  }
  for (int k = b.count(1, 10); k > 0; --k) {
    const double length = height * b.between(0.12, 0.4);
    add_leaf(b, t, leaf, place_on(trunk, metres(b.between(0.02, 0.8))).position, b.outward(b.between(0, 0.8)),
             metres(length), metres(length * b.between(0.15, 0.6)), metres(height * b.log_between(0.0006, 0.003)));
  }
}

void make_grass_tuft(ObjectBuilder& b) {
  const PlantTissue t = herb(b);
  const int blade = b.new_part(), ear = b.new_part();
  const double height = b.log_between(0.08, 1.2), blades = b.count(8, 30), foot = b.log_between(0.1, 0.6);
  for (int k = 0; k < blades; ++k) {
    const double length = height * b.between(0.5, 1), width = height * b.log_between(0.008, 0.03);
    const Vec3f root = metres(0.05 * height * b.between(0, 1)) * b.outward(0), side = b.outward(0);
    const Vec3f colour = b.tint(t.green, 0.05);
    // Sheaths and supporting strands make a blade stiffest at its foot.
    b.add(
        Sheet(
            curve(root, b.outward(b.between(0.75, 0.98)), metres(length), -Vec3f::UnitZ() + b.outward(0),
                  metres(b.between(0.2, 1.8))),
            side, [=](float s) { return metres(0.5 * width) * std::sqrt(1.02f - s); }, 0.5f, metres(height * 0.0015)),
        blade, [colour](const ShapePoint&) { return colour; },
        [t, foot](const ShapePoint& p) {
          return Substance{4 * t.leaf * std::pow(foot, p.along) * (std::abs(p.across) < 0.15f ? t.vein : 1.0), 0.35,
                           700};
        });
  }
  const Vec3f straw = b.tint({0.7f, 0.6f, 0.35f});
  for (int k = b.count(0, 6); k > 0; --k) {
    const auto stalk = curve(Vec3f::Zero(), b.outward(b.between(0.85, 1)), metres(height * 1.1), b.outward(0),
                             metres(b.between(0, 0.7)));
    add_stem(b, t, blade, stalk, metres(height * 0.006), metres(height * 0.003));
    const CurvePlace top = place_on(stalk, 1);
    b.add(Tube(curve(top.position, top.tangent, metres(0.15 * height), b.outward(0), 0.3f), metres(height * 0.014),
               metres(height * 0.005)),
          ear, straw, Substance{t.head, 0.3, 400});
  }
}

void make_fern(ObjectBuilder& b) {
  const PlantTissue t = herb(b);
  const int stem = b.new_part(), leaf = b.new_part();
  const double height = b.log_between(0.15, 1.0);
  for (int k = b.count(3, 9); k > 0; --k) {
    const double length = height * b.between(0.7, 1.1);
    const auto rachis = curve(Vec3f::Zero(), b.outward(b.between(0.6, 0.95)), metres(length), -Vec3f::UnitZ(),
                              metres(b.between(0.4, 1.6)));
    add_stem(b, t, stem, rachis, metres(0.01 * height), metres(0.003 * height));
    const int pairs = b.count(6, 14);
    for (int i = 0; i < 2 * pairs; ++i) {
      const float at = 0.2f + 0.8f * static_cast<float>(i / 2) / static_cast<float>(pairs);
      const CurvePlace place = place_on(rachis, at);
      const Vec3f side = place.tangent.cross(Vec3f::UnitZ()).normalized() * (i % 2 ? 1.0f : -1.0f);
      const double pinna = length * 0.3 * (1.1 - at);
      add_leaf(b, t, leaf, place.position, side + 0.4f * place.tangent, metres(pinna), metres(0.25 * pinna),
               metres(0.001 * height));
    }
  }
}

void make_bonsai(ObjectBuilder& b) {
  const PlantTissue t = woody(b);
  const int trunk_part = b.new_part(), crown = b.new_part();
  const double height = b.log_between(0.15, 1.5), radius = height * b.between(0.03, 0.09);
  const float ground =
      b.chance(0.5) ? add_pot(b, metres(height * b.between(0.15, 0.3)), metres(height * b.between(0.1, 0.25))) : 0.0f;
  const bool clumps = b.chance(0.6);
  const double clump = b.log_between(2e4, 2e6);  // twigs and leaves smeared out: mostly air
  const auto trunk = curve({0, 0, ground}, b.outward(b.between(0.8, 1)), metres(0.6 * height), b.outward(0.3),
                           metres(b.between(0, 1)));
  add_stem(b, t, trunk_part, trunk, metres(radius), metres(0.5 * radius), 0, 0.5);
  for (int k = b.count(3, 7); k > 0; --k) {
    const double at = b.between(0.4, 1), length = height * b.between(0.2, 0.45);
    const auto branch = curve(place_on(trunk, metres(at)).position, b.outward(b.between(0.1, 0.8)), metres(length),
                              Vec3f::UnitZ(), metres(b.between(0, 0.7)));
    add_stem(b, t, trunk_part, branch, metres(0.45 * radius), metres(0.15 * radius), 0.5 * at, 1);
    if (clumps) {
      const Vec3f radii(metres(length * b.between(0.3, 0.6)), metres(length * b.between(0.3, 0.6)),
                        metres(length * b.between(0.15, 0.3)));
      b.add(Ellipsoid(branch.back(), radii), crown, b.tint(t.green, 0.04), Substance{clump, 0.3, 250});
    } else {
      for (int i = 0; i < 12; ++i)
        add_leaf(b, t, crown, place_on(branch, metres(b.between(0.3, 1))).position, b.outward(b.between(-0.2, 0.9)),
                 metres(0.12 * height), metres(0.06 * height), metres(0.001 * height));
    }
  }
}

void make_cactus(ObjectBuilder& b) {
  const double height = b.log_between(0.06, 0.8), radius = height * b.between(0.12, 0.45);
  const float ground = b.chance(0.6) ? add_pot(b, metres(1.2 * radius + 0.02), metres(0.4 * height)) : 0.0f;
  const int body = b.new_part(), arm = b.new_part();
  const double flesh = b.log_between(1e6, 1.2e7), skin = b.log_between(2, 12), age = b.log_between(2, 30);
  const Vec3f green = b.tint({0.3f, 0.45f, 0.3f});
  // Water tissue under a stiff skin; the foot of an old one turns to cork and wood.
  const auto tissue = [=](const ShapePoint& p) {
    return Substance{flesh * (p.across > 0.85f ? skin : 1) * (1 + (age - 1) * std::exp(-6.0 * p.along)), 0.4, 960};
  };
  const auto look = [=](const ShapePoint& p) { return Vec3f(green * (1 - 0.3f * std::exp(-6 * p.along))); };
  b.add(Lathe({0, 0, ground}, Vec3f::UnitZ(), metres(height),
              [=](float s) {
                return metres(radius) * std::sqrt(std::max(0.05f, 1.02f - std::pow(std::abs(1.6f * s - 0.6f), 3.0f)));
              }),
        body, look, tissue);
  for (int k = b.count(0, 4); k > 0; --k) {
    const auto chain = curve({0, 0, ground + metres(height * b.between(0.3, 0.7))}, b.outward(0.1),
                             metres(height * b.between(0.3, 0.7)), Vec3f::UnitZ(), 1.4f);
    b.add(Tube(chain, metres(0.4 * radius), metres(0.35 * radius)), arm, look, [=](const ShapePoint& p) {
      return Substance{flesh * (p.across > 0.85f ? skin : 1), 0.4, 960};
    });
  }
}

void make_succulent(ObjectBuilder& b) {
  const PlantTissue t = herb(b);
  const double height = b.log_between(0.06, 0.5);
  const float ground =
      b.chance(0.7) ? add_pot(b, metres(height * b.between(0.3, 0.5)), metres(height * b.between(0.3, 0.6))) : 0.0f;
  const int leaf = b.new_part();
  for (int k = b.count(8, 24); k > 0; --k) {
    const double length = height * b.between(0.5, 1), width = length * b.between(0.15, 0.35),
                 foot = b.between(0.3, 0.6);
    const Vec3f colour = b.tint(t.green, 0.04);
    b.add(
        Sheet(
            curve({0, 0, ground}, b.outward(b.between(0.2, 0.95)), metres(length), Vec3f::UnitZ(),
                  metres(b.between(-0.5, 0.8))),
            b.outward(0), [=](float s) { return metres(0.5 * width) * std::sqrt(1.02f - s); }, -0.3f,
            metres(0.25 * width)),
        leaf, [colour](const ShapePoint&) { return colour; },
        // Water leaves: soft within, skin and foot stiffer.
        [=](const ShapePoint& p) {
          return Substance{0.3 * t.leaf * std::pow(foot, p.along) * (p.depth < 0.03 * width ? 3 : 1), 0.42, 980};
        });
  }
}

void make_mushroom(ObjectBuilder& b) {
  const int stalk = b.new_part(), cap = b.new_part();
  const double height = b.log_between(0.04, 0.25), radius = height * b.between(0.08, 0.2),
               young = b.log_between(2e5, 4e6);
  const double soft = b.log_between(0.1, 0.7), top = height * b.between(0.35, 0.8), skin = b.log_between(1, 4);
  const Vec3f white = b.tint({0.85f, 0.8f, 0.7f}, 0.06), brown = b.tint({0.55f, 0.35f, 0.2f}, 0.15);
  // Fibres run along the stalk; the cap is looser, its underside the softest.
  b.add(
      Tube(curve(Vec3f::Zero(), b.outward(0.97), metres(height), b.outward(0), metres(b.between(0, 0.4))),
           metres(radius), metres(0.75 * radius)),
      stalk, [white](const ShapePoint&) { return white; },
      [=](const ShapePoint& p) {
        return Substance{young * std::pow(0.6, p.along), 0.35, 700};
      });
  const float low = metres(height * b.between(0.7, 0.95)), tall = metres(height * b.between(0.2, 0.4));
  b.add(
      Lathe({0, 0, low}, Vec3f::UnitZ(), tall,
            [=](float s) { return metres(top) * std::sqrt(std::max(0.02f, 1 - s * s)); }),
      cap, [=](const ShapePoint& p) { return p.along < 0.15f ? white : brown; },
      [=](const ShapePoint& p) {
        return Substance{young * soft * (p.along < 0.3f ? 0.6 : 1) * (p.across > 0.9f ? skin : 1), 0.3, 550};
      });
}

void make_fruit(ObjectBuilder& b) {
  const PlantTissue t = woody(b);
  const int flesh = b.new_part(), stalk = b.new_part(), leaf = b.new_part();
  const double radius = b.log_between(0.012, 0.12), young = b.log_between(3e5, 6e6), skin = b.log_between(3, 20);
  const float tall = metres(radius * b.between(0.8, 1.4));
  b.add(
      Ellipsoid({0, 0, tall}, {metres(radius), metres(radius), tall}), flesh,
      [colour = b.any_colour()](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) {
        return Substance{young * (p.across > 0.93f ? skin : p.across < 0.3f ? 2.0 : 1.0), 0.38, 950};
      });
  add_stem(b, t, stalk,
           curve({0, 0, 1.95f * tall}, b.outward(0.95), metres(radius * b.between(0.3, 0.9)), b.outward(0), 0.5f),
           metres(0.07 * radius), metres(0.06 * radius), 0.5, 0.8);
  for (int k = b.count(0, 2); k > 0; --k)
    add_leaf(b, t, leaf, {0, 0, 2.1f * tall}, b.outward(0.4), metres(1.2 * radius), metres(0.5 * radius),
             metres(0.01 * radius));
}

}  // namespace

std::vector<ObjectFamily> plant_families() {
  return {{"flower", FamilyRole::kTrain, make_flower},      {"grass_tuft", FamilyRole::kTrain, make_grass_tuft},
          {"bonsai", FamilyRole::kTrain, make_bonsai},      {"cactus", FamilyRole::kTrain, make_cactus},
          {"fern", FamilyRole::kValidate, make_fern},       {"fruit", FamilyRole::kValidate, make_fruit},
          {"succulent", FamilyRole::kTest, make_succulent}, {"mushroom", FamilyRole::kTest, make_mushroom}};
}

}  // namespace pliant
