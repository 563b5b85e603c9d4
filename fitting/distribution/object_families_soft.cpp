#include <Eigen/Geometry>
#include <cmath>

#include "fitting/distribution/object_families.h"

namespace pliant {
namespace {

/// Stuffing under a cover: the cover carries the stress, seams are doubled and sewn.
struct Upholstery {
  Substance stuffing, cover;
  double seam = 3;
  float cover_depth = 0;  ///< how far below the surface the cover counts, a share of the smallest radius
};

Upholstery upholstery(ObjectBuilder& b) {
  Upholstery u;
  u.stuffing = b.chance(0.5) ? foam(b) : Substance{b.log_between(1e3, 2e4), b.between(0.05, 0.3), b.between(15, 60)};
  u.cover = cloth(b);
  u.cover.young = std::min(u.cover.young, u.stuffing.young * b.log_between(10, 1000));  // smeared over its depth
  u.seam = b.log_between(1.5, 8);
  u.cover_depth = metres(b.between(0.04, 0.12));
  return u;
}

ObjectBuilder::Filling stuffed(const Upholstery& u, float smallest) {
  return [=](const ShapePoint& p) {
    return p.depth < u.cover_depth * smallest ? Substance{u.cover.young, u.cover.poisson, 0.5 * u.cover.density}
                                              : u.stuffing;
  };
}

void add_seam(ObjectBuilder& b, int part, const Upholstery& u, const std::vector<Vec3f>& chain, float radius,
              const Vec3f& colour) {
  b.add(Tube(chain, radius, radius), part, colour, stiffer(u.cover, u.seam));
}

std::vector<Vec3f> ring(const Vec3f& centre, float a, float c, const Vec3f& first, const Vec3f& second) {
  std::vector<Vec3f> out;
  for (int i = 0; i <= 32; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / 32;
    out.push_back(centre + a * std::cos(angle) * first + c * std::sin(angle) * second);
  }
  return out;
}

void make_soft_toy(ObjectBuilder& b) {
  const Upholstery u = upholstery(b);
  const float r = metres(b.log_between(0.03, 0.2));
  const Vec3f fur = b.any_colour(), dark = b.tint({0.1f, 0.1f, 0.1f}, 0.05), pad = b.tint(fur, 0.2);
  const int body = b.new_part(), head = b.new_part(), limb = b.new_part(), eye = b.new_part(), seam = b.new_part();
  const auto lump = [&](int part, const Vec3f& centre, const Vec3f& radii, const Vec3f& axis, const Vec3f& colour) {
    b.add(
        Ellipsoid(centre, radii, axes_along(axis)), part, [colour](const ShapePoint&) { return colour; },
        stuffed(u, radii.minCoeff()));
  };
  const float tall = metres(b.between(1, 1.6)), size = metres(b.between(0.6, 1));
  const Vec3f neck(0, 0, 2 * tall * r);
  lump(body, {0, 0, tall * r}, {r, 0.9f * r, tall * r}, Vec3f::UnitZ(), fur);
  const Vec3f face = neck + Vec3f(0, 0, 0.7f * size * r);
  lump(head, face, Vec3f(size, size, 0.9f * size) * r, Vec3f::UnitZ(), fur);
  const int legs = b.count(2, 4);
  for (int k = 0; k < legs; ++k) {
    const float side = k % 2 ? 1.0f : -1.0f, low = k < 2 ? 0.2f : 1.4f;
    lump(limb, {side * 0.9f * r, 0.4f * r, low * tall * r}, Vec3f(0.3f, 0.3f, metres(b.between(0.5, 1))) * r,
         Vec3f(side, 0.7f, -0.2f), b.chance(0.5) ? fur : pad);
  }
  for (const float side : {-1.0f, 1.0f}) {
    lump(limb, face + Vec3f(side * 0.7f, 0, 0.8f) * size * r, Vec3f(0.3f, 0.15f, 0.35f) * size * r, Vec3f(side, 0, 1),
         pad);
    b.add(Ellipsoid(face + Vec3f(side * 0.35f, 0.9f, 0.2f) * size * r, Vec3f::Constant(0.12f * size * r)), eye, dark,
          plastic(b));
  }
  if (b.chance(0.8))
    add_seam(b, seam, u, ring({0, 0, tall * r}, r, tall * r, Vec3f::UnitX(), Vec3f::UnitZ()), 0.06f * r,
             b.tint(fur * 0.6f, 0.05));
}

void make_cushion(ObjectBuilder& b) {
  const Upholstery u = upholstery(b);
  const float r = metres(b.log_between(0.1, 0.4)), flat = metres(b.between(0.2, 0.5));
  const bool upright = b.chance(0.4);
  const Vec3f colour = b.any_colour(), up = upright ? Vec3f::UnitY() : Vec3f::UnitZ();
  const Mat3f axes = axes_along(up);
  const int body = b.new_part(), seam = b.new_part(), button = b.new_part();
  const Vec3f centre(0, 0, upright ? r : flat * r);
  b.add(
      Ellipsoid(centre, Vec3f(r, r * metres(b.between(0.6, 1)), flat * r), axes), body,
      [colour](const ShapePoint&) { return colour; }, stuffed(u, flat * r));
  if (b.chance(0.75))
    add_seam(b, seam, u, ring(centre, r, r, axes.col(0), axes.col(1)), 0.025f * r, b.tint(colour * 0.7f));
  if (b.chance(0.3))
    b.add(Ellipsoid(centre + flat * r * up, Vec3f::Constant(0.07f * r)), button, b.any_colour(), plastic(b));
}

void make_bread(ObjectBuilder& b) {
  // Crumb is an open foam of wet starch; the crust is dry and dense.  Ratio: Gibson and Ashby's square law with the
  // density of crust three to six times that of crumb, and drying by another decade.
  const double crumb = b.log_between(2e3, 5e4), ratio = b.log_between(10, 1000), r = b.log_between(0.03, 0.15);
  const float crust = metres(b.between(0.04, 0.14));
  const Vec3f brown = b.tint({0.62f, 0.4f, 0.2f}, 0.08), pale = b.tint({0.85f, 0.75f, 0.55f}, 0.05);
  const double base = b.between(0.3, 1), rho = b.between(180, 320), tall = b.between(0.4, 0.8),
               length = b.between(1, 2.6);
  const bool sliced = b.chance(0.35);
  const int loaf = b.new_part(), topping = b.new_part();
  const Vec3f radii(metres(r * length), metres(r), metres(r * tall));
  b.add(
      Ellipsoid({0, 0, radii.z()}, radii), loaf,
      [=](const ShapePoint& p) { return sliced && p.across < 0.7f ? pale : Vec3f(brown * (1.25f - 0.45f * p.along)); },
      [=](const ShapePoint& p) {
        // The bottom crust is thinner and softer than the one that faced the fire.
        if (p.depth > crust * radii.minCoeff()) return Substance{crumb, 0.15, rho};
        return Substance{crumb * ratio * (p.along < 0.3f ? base : 1.0), 0.25, 2.2 * rho};
      });
  if (b.chance(0.25))
    b.add(Ellipsoid({0, 0, 1.6f * radii.z()}, radii * 0.45f), topping, b.any_colour(),
          Substance{b.log_between(1e4, 1e6), 0.4, 1000});
}

void make_cake(ObjectBuilder& b) {
  const float radius = metres(b.log_between(0.04, 0.15)), layer = radius * metres(b.between(0.15, 0.4));
  const double crumb = b.log_between(3e3, 4e4), cream = b.log_between(1e3, 3e4);
  const int sponge = b.new_part(), filling = b.new_part(), plate = b.new_part(), top = b.new_part();
  const Vec3f dough = b.any_colour(), white = b.any_colour();
  float z = 0;
  if (b.chance(0.5)) {
    z = 0.05f * radius;
    b.add(Lathe(Vec3f::Zero(), Vec3f::UnitZ(), z, [=](float) { return 1.4f * radius; }), plate, b.any_colour(),
          b.chance(0.6) ? hard_ware(b) : plastic(b));
  }
  for (int k = b.count(1, 4); k > 0; --k) {
    b.add(
        Lathe({0, 0, z}, Vec3f::UnitZ(), layer, [=](float) { return radius; }), sponge,
        [dough](const ShapePoint&) { return dough; },
        [=](const ShapePoint& p) {
          return Substance{crumb * (p.depth < 0.1f * layer ? 4 : 1), 0.2, 350};
        });
    z += layer;
    b.add(Lathe({0, 0, z}, Vec3f::UnitZ(), 0.2f * layer, [=](float) { return radius; }), filling, white,
          Substance{cream, 0.45, 700});
    z += 0.2f * layer;
  }
  const Substance berry = {b.log_between(1e5, 2e6), 0.4, 950};
  const Vec3f red = b.any_colour();
  for (int k = b.count(0, 8); k > 0; --k) {
    const Vec3f at = b.outward(0) * radius * 0.75f;
    b.add(Ellipsoid({at.x(), at.y(), z + 0.08f * radius}, Vec3f::Constant(0.12f * radius)), top, red, berry);
  }
}

void make_cord(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.2, 2)), radius = length * metres(b.log_between(0.006, 0.03));
  const bool cable = b.chance(0.5), hangs = b.chance(0.5);
  const double core = cable ? b.log_between(1e8, 5e9) : b.log_between(2e7, 2e9),
               jacket = cable ? b.log_between(3e6, 1e8) : core * b.between(0.4, 1);
  const Vec3f colour = b.any_colour();
  const int cord = b.new_part(), end = b.new_part();
  const auto chain = hangs ? curve({0, 0, length}, {0.1f, 0, -1}, length, Vec3f::UnitX(), metres(b.between(0, 1.5)))
                           : curve({0, 0, radius}, b.outward(0), length, b.outward(0), metres(b.between(0.5, 5)));
  // Wires or parallel fibres within, a soft jacket or a braid around.
  b.add(
      Tube(chain, radius, radius), cord, [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) {
        return p.across < 0.55f ? Substance{core, 0.35, cable ? 3000.0 : 900.0} : Substance{jacket, 0.42, 1200};
      });
  if (cable || b.chance(0.4)) {
    const Substance plug = cable ? plastic(b) : stiffer(cloth(b), 3);
    const Vec3f other = b.any_colour();
    for (const float at : {0.0f, 1.0f}) {
      const CurvePlace p = place_on(chain, at);
      if (at > 0 || b.chance(0.5))
        b.add(Ellipsoid(p.position, Vec3f(2.2f, 2.2f, 6) * radius, axes_along(p.tangent)), end, other, plug);
    }
  }
}

void make_shoe(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.1, 0.32)), wide = 0.18f * length,
              sole = length * metres(b.between(0.05, 0.1));
  const Substance rubber = {b.log_between(2e6, 2e7), 0.47, b.between(400, 1200)},
                  upper = {b.log_between(5e6, 3e8), 0.35, b.between(300, 900)};
  const Substance pad = foam(b), lace = cloth(b);
  const Vec3f colour = b.any_colour(), other = b.any_colour();
  const int bottom = b.new_part(), top = b.new_part(), laces = b.new_part();
  const double heel = b.log_between(1, 5);  // a counter holds the heel
  b.add(
      Ellipsoid({0, 0, sole + 0.12f * length}, Vec3f(0.5f * length, wide, 0.2f * length), Mat3f::Identity(),
                0.04f * length),
      top, [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) { return p.across < 0.5f ? pad : stiffer(upper, p.along < 0.4f ? heel : 1); });
  for (int k = 0; k < b.count(0, 5); ++k)
    b.add(Tube(curve({0.08f * length * metres(k), -0.5f * wide, sole + 0.3f * length}, Vec3f::UnitY(), wide,
                     -Vec3f::UnitZ(), 0.3f),
               0.012f * length, 0.012f * length),
          laces, b.any_colour(), lace);
  b.add(Cuboid({0, 0, 0.5f * sole}, Vec3f(0.5f * length, wide, 0.5f * sole)), bottom, other, rubber);
}

void make_hat(ObjectBuilder& b) {
  const float radius = metres(b.log_between(0.05, 0.11)), height = radius * metres(b.between(0.7, 1.6)),
              brim = radius * metres(b.between(0.3, 1.2));
  const float thick = radius * metres(b.between(0.02, 0.06)), narrow = metres(b.between(0.5, 0.95));
  const Substance felt = {b.log_between(1e6, 3e7), 0.25, b.between(150, 400)},
                  band = stiffer(cloth(b), b.log_between(1, 5));
  const double edge = b.log_between(1, 6), stiffened = b.log_between(0.4, 4);
  const Vec3f colour = b.any_colour(), ribbon = b.any_colour();
  const int crown = b.new_part(), rim = b.new_part(), band_part = b.new_part();
  const auto outer = [=](float s) {
    return radius * (narrow + (1 - narrow) * std::sqrt(1 - s)) *
           (s > 0.9f ? std::sqrt(std::max(0.05f, 10 * (1 - s))) : 1.0f);
  };
  b.add(Lathe(Vec3f::Zero(), Vec3f::UnitZ(), height, outer,
              [=](float s) { return s > 0.95f ? 0.0f : std::max(0.01f * radius, outer(s) - thick); }),
        crown, colour, felt);
  // A brim is sized with shellac, its edge bound or wired.
  b.add(
      Lathe(
          {0, 0, -0.5f * thick}, Vec3f::UnitZ(), thick, [=](float) { return radius + brim; },
          [=](float) { return 0.95f * radius; }),
      rim, [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) { return stiffer(felt, stiffened * (p.across > 0.9f ? edge : 1)); });
  if (b.chance(0.75))
    b.add(Lathe(
              {0, 0, thick}, Vec3f::UnitZ(), 0.18f * height, [=](float) { return radius + thick; },
              [=](float) { return radius; }),
          band_part, ribbon, band);
}

}  // namespace

std::vector<ObjectFamily> soft_families() {
  return {{"soft_toy", FamilyRole::kTrain, make_soft_toy},
          {"cushion", FamilyRole::kTrain, make_cushion},
          {"bread", FamilyRole::kTrain, make_bread},
          {"cake", FamilyRole::kTrain, make_cake},
          {"cord", FamilyRole::kTrain, make_cord},
          {"shoe", FamilyRole::kValidate, make_shoe},
          {"hat", FamilyRole::kTest, make_hat}};
}

}  // namespace pliant
