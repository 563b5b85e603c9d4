#include <Eigen/Geometry>
#include <cmath>

#include "fitting/distribution/object_families.h"

namespace pliant {
namespace {

Substance rubber(ObjectBuilder& b) { return {b.log_between(5e5, 2e7), 0.48, b.between(900, 1300)}; }
Substance leather(ObjectBuilder& b) { return {b.log_between(2e7, 3e8), 0.4, b.between(700, 1000)}; }
Substance card(ObjectBuilder& b) { return {b.log_between(5e8, 4e9), 0.3, b.between(400, 900)}; }
Substance flesh(ObjectBuilder& b) { return {b.log_between(2e5, 2e7), 0.4, b.between(800, 1050)}; }
Substance stuffing(ObjectBuilder& b) { return {b.log_between(1e3, 3e4), b.between(0.05, 0.3), b.between(15, 70)}; }
Substance rigid(ObjectBuilder& b) {
  const double kind = b.between(0, 1);
  return kind < 0.35 ? wood(b) : kind < 0.65 ? plastic(b) : kind < 0.85 ? metal(b) : hard_ware(b);
}

/// A rectangle of cloth, paper or the like between two edges.
void add_panel(ObjectBuilder& b, int part, const Vec3f& from, const Vec3f& to, const Vec3f& side, float first,
               float last, float thick, const Vec3f& colour, const Substance& s) {
  b.add(Sheet(
            straight(from, to), side, [=](float a) { return first + (last - first) * a; }, metres(b.between(-0.3, 0.3)),
            thick),
        part, colour, s);
}

/// One thing out of many, about `size` large and resting on height `z`; returns the height of its top.  Which
/// substances a shape may have is what there is in a house: rods are rigid, of plants or of rope, sheets of cloth,
/// paper, leather or leaf, lumps of anything.
float add_anything(ObjectBuilder& b, const Vec3f& at, float size) {
  const int part = b.new_part();
  const Vec3f colour = b.any_colour();
  const double shape = b.between(0, 1), kind = b.between(0, 1);
  if (shape < 0.25) {
    const Substance s = kind < 0.6   ? rigid(b)
                        : kind < 0.8 ? stiffer(cloth(b), 5)
                                     : Substance{b.log_between(2e7, 5e9), 0.35, 900};
    const float length = size * metres(b.between(1, 3)), radius = size * metres(b.between(0.02, 0.1));
    const auto chain =
        curve(at, b.outward(b.between(0.3, 1)), length, b.outward(0), metres(b.between(0, kind < 0.6 ? 0.2 : 1)));
    b.add(Tube(chain, radius, radius * metres(b.between(0.5, 1))), part, colour, s);
    return chain.back().z();
  }
  if (shape < 0.45) {
    const Substance s = kind < 0.45   ? cloth(b)
                        : kind < 0.65 ? card(b)
                        : kind < 0.8  ? leather(b)
                                      : Substance{b.log_between(3e6, 6e7), 0.33, 800};
    const Vec3f to = at + b.outward(b.between(0, 0.95)) * size * metres(b.between(0.8, 2));
    add_panel(b, part, at, to, b.outward(0), size * metres(b.between(0.2, 0.8)), size * metres(b.between(0.1, 0.8)),
              size * metres(b.between(0.005, 0.03)), colour, s);
    return std::max(at.z(), to.z());
  }
  const Vec3f radii =
      size * Vec3f(metres(b.between(0.3, 0.7)), metres(b.between(0.3, 0.7)), metres(b.between(0.15, 0.6)));
  const Vec3f centre = at + Vec3f(0, 0, radii.z());
  if (shape < 0.65) {
    const Substance s = rigid(b);
    const float wall = radii.minCoeff() * metres(b.between(0.06, 0.2));
    b.add(Ellipsoid(centre, radii, Mat3f::Identity(), wall), part, colour, b.chance(0.7) ? s : card(b));
  } else if (shape < 0.8) {
    const Substance s = kind < 0.5 ? rigid(b) : kind < 0.75 ? foam(b) : card(b);
    b.add(Cuboid(centre, radii), part, colour, s);
  } else {
    const Substance core = kind < 0.25   ? flesh(b)
                           : kind < 0.5  ? stuffing(b)
                           : kind < 0.65 ? foam(b)
                           : kind < 0.8  ? rubber(b)
                                         : rigid(b);
    const double skin = kind < 0.65 ? b.log_between(1, 100) : 1;
    b.add(
        Ellipsoid(centre, radii), part, [colour](const ShapePoint&) { return colour; },
        [=](const ShapePoint& p) { return stiffer(core, p.across > 0.9f ? skin : 1); });
  }
  return centre.z() + radii.z();
}

void make_assembly(ObjectBuilder& b) {
  const float size = metres(b.log_between(0.03, 0.5));
  Vec3f at = Vec3f::Zero();
  float top = 0;
  for (int k = b.count(2, 6); k > 0; --k) {
    top = std::max(top, add_anything(b, at, size * metres(b.log_between(0.4, 1.5))));
    const Vec3f aside = b.outward(0) * size * metres(b.between(0, 0.6));
    at = Vec3f(aside.x(), aside.y(), b.chance(0.6) ? 0.9f * top : 0.0f);
  }
}

void make_sailboat(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.15, 2.5)), wide = length * metres(b.between(0.12, 0.2)),
              deep = length * metres(b.between(0.08, 0.15)), mast = length * metres(b.between(0.9, 1.4));
  const Substance hull = b.chance(0.5) ? wood(b) : plastic(b), spar = b.chance(0.5) ? wood(b) : metal(b),
                  sail = cloth(b), rope = stiffer(cloth(b), b.log_between(3, 30));
  const int hull_part = b.new_part(), spar_part = b.new_part(), sail_part = b.new_part(), rope_part = b.new_part();
  const Vec3f white = b.chance(0.6) ? b.tint({0.9f, 0.88f, 0.82f}, 0.05) : b.any_colour();
  b.add(Ellipsoid({0, 0, deep}, {0.5f * length, wide, deep}, Mat3f::Identity(), 0.1f * deep), hull_part, b.any_colour(),
        hull);
  const float radius = 0.012f * length, boom = deep * 2.2f;
  b.add(Tube(straight({0.1f * length, 0, deep}, {0.1f * length, 0, mast}), radius, 0.6f * radius), spar_part,
        b.any_colour(), spar);
  b.add(Tube(straight({0.1f * length, 0, boom}, {-0.4f * length, 0, boom}), 0.7f * radius, 0.7f * radius), spar_part,
        b.any_colour(), spar);
  const Vec3f foot(-0.15f * length, 0, boom), peak(0.08f * length, 0, 0.97f * mast);
  add_panel(b, sail_part, foot, peak, Vec3f::UnitX(), 0.24f * length, 0.01f * length, 0.002f * length, white, sail);
  add_panel(b, sail_part, {0.3f * length, 0, boom}, {0.13f * length, 0, 0.85f * mast}, Vec3f::UnitX(), 0.16f * length,
            0.01f * length, 0.002f * length, white, sail);
  for (const float end : {-0.48f, 0.48f})
    b.add(Tube(straight({0.1f * length, 0, mast}, {end * length, 0, deep}), 0.15f * radius, 0.15f * radius), rope_part,
          b.any_colour(), rope);
}

void make_tool(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.1, 1)), radius = length * metres(b.between(0.02, 0.06));
  const Substance head = b.chance(0.85) ? metal(b) : rubber(b), handle = b.chance(0.6) ? wood(b) : plastic(b),
                  grip = b.chance(0.5) ? rubber(b) : foam(b);
  const int head_part = b.new_part(), handle_part = b.new_part(), grip_part = b.new_part();
  const bool lies = b.chance(0.5);
  const Vec3f along = lies ? Vec3f(b.outward(0)) : Vec3f::UnitZ(), start(0, 0, lies ? radius : 0);
  b.add(Tube(straight(start, start + length * along), radius, radius * metres(b.between(0.6, 1))), handle_part,
        b.any_colour(), handle);
  if (b.chance(0.6))
    b.add(Tube(straight(start, start + length * metres(b.between(0.2, 0.5)) * along), 1.35f * radius, 1.35f * radius),
          grip_part, b.any_colour(), grip);
  const Vec3f half = radius * Vec3f(metres(b.between(1, 2.5)), metres(b.between(1.5, 6)), metres(b.between(0.4, 2)));
  b.add(Cuboid(start + length * along, half, axes_along(along)), head_part, b.tint({0.55f, 0.55f, 0.57f}, 0.08), head);
}

void make_vehicle(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.05, 1.5)), wide = length * metres(b.between(0.35, 0.55)),
              wheel = length * metres(b.between(0.09, 0.16)), high = length * metres(b.between(0.1, 0.2));
  const Substance body = rigid(b), tyre = rubber(b), axle = metal(b), seat = foam(b);
  const int body_part = b.new_part(), wheel_part = b.new_part(), axle_part = b.new_part(), seat_part = b.new_part();
  const Vec3f black = b.tint({0.1f, 0.1f, 0.1f}, 0.05);
  b.add(Cuboid({0, 0, 1.4f * wheel + high}, {0.5f * length, 0.5f * wide, high}), body_part, b.any_colour(), body);
  if (b.chance(0.5))
    b.add(Cuboid({0, 0, 1.4f * wheel + 2.2f * high}, {0.2f * length, 0.35f * wide, 0.3f * high}), seat_part,
          b.any_colour(), seat);
  for (const float x : {-0.33f, 0.33f}) {
    b.add(Tube(straight({x * length, -0.6f * wide, wheel}, {x * length, 0.6f * wide, wheel}), 0.15f * wheel,
               0.15f * wheel),
          axle_part, b.tint({0.6f, 0.6f, 0.6f}), axle);
    for (const float y : {-0.55f, 0.55f})
      b.add(Lathe({x * length, y * wide - 0.2f * wheel, wheel}, Vec3f::UnitY(), 0.4f * wheel,
                  [=](float) { return wheel; }),
            wheel_part, black, tyre);
  }
}

void make_basket(ObjectBuilder& b) {
  // Woven willow or straw bends far more easily than the wood that it is.
  const float radius = metres(b.log_between(0.06, 0.3)), height = radius * metres(b.between(0.5, 1.2)),
              thick = radius * metres(b.between(0.04, 0.1));
  const Substance weave = {b.log_between(2e7, 1e9), 0.2, b.between(200, 450)}, lining = cloth(b);
  const int wall = b.new_part(), cover = b.new_part(), food = b.new_part();
  const Vec3f straw = b.tint({0.62f, 0.47f, 0.28f}, 0.08);
  const auto outer = [=](float s) { return radius * (0.75f + 0.25f * s); };
  const float floor = 1.5f * thick / height;
  b.add(
      Lathe(Vec3f::Zero(), Vec3f::UnitZ(), height, outer, [=](float s) { return s < floor ? 0.0f : outer(s) - thick; }),
      wall, straw, weave);
  if (b.chance(0.7))
    b.add(Tube(curve({radius, 0, height}, Vec3f(0.1f, 0, 1), 3.1f * radius, Vec3f(-1, 0, -1), 3.0f), thick, thick),
          wall, straw, stiffer(weave, 3));
  if (b.chance(0.5))
    add_panel(b, cover, {0.8f * radius, 0, height}, {1.1f * radius, 0, 0.4f * height}, Vec3f::UnitY(), 0.6f * radius,
              0.6f * radius, 0.1f * thick, b.any_colour(), lining);
  const bool bread = b.chance(0.4);
  const Substance pulp = bread ? Substance{b.log_between(2e3, 5e4), 0.15, 250} : flesh(b);
  const double skin = bread ? b.log_between(10, 300) : b.log_between(1, 10);
  const Vec3f colour = b.any_colour();
  for (int k = b.count(1, 7); k > 0; --k) {
    const float r = radius * metres(b.between(0.2, 0.4));
    const Vec3f out = b.outward(0) * radius * metres(b.between(0, 0.5));
    b.add(
        Ellipsoid({out.x(), out.y(), height * metres(b.between(0.4, 1))}, Vec3f::Constant(r)), food,
        [c = b.tint(colour)](const ShapePoint&) { return c; },
        [=](const ShapePoint& p) { return stiffer(pulp, p.across > 0.92f ? skin : 1); });
  }
}

void make_sweet(ObjectBuilder& b) {
  const float r = metres(b.log_between(0.01, 0.06)), stick = r * metres(b.between(3, 8));
  const double kind = b.between(0, 1);
  const Substance sweet = kind < 0.35   ? Substance{b.log_between(1e9, 8e9), 0.3, 1500}    // boiled sugar is a glass
                          : kind < 0.65 ? Substance{b.log_between(5e3, 1e5), 0.3, 350}     // marshmallow, candy floss
                          : kind < 0.85 ? Substance{b.log_between(1e5, 3e6), 0.4, 1200}    // caramel, fruit gum
                                        : Substance{b.log_between(1e8, 1e9), 0.33, 1250};  // chocolate
  const Substance rod = b.chance(0.5) ? wood(b) : b.chance(0.5) ? card(b) : plastic(b);
  const int ball = b.new_part(), rod_part = b.new_part();
  b.add(Tube(straight(Vec3f::Zero(), {0, 0, stick}), 0.1f * r, 0.1f * r), rod_part, b.tint({0.88f, 0.82f, 0.7f}), rod);
  for (int k = b.count(1, 3); k > 0; --k)
    b.add(Ellipsoid({0, 0, stick + r * metres(1.6 * (k - 1))}, Vec3f(r, r * metres(b.between(0.3, 1)), r)), ball,
          b.any_colour(), sweet);
}

void make_mobile(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.2, 1)), radius = 0.012f * length;
  const Substance bar = b.chance(0.6) ? wood(b) : metal(b), thread = stiffer(cloth(b), b.log_between(3, 30));
  const double kind = b.between(0, 1);
  const Substance figure = kind < 0.35  ? Substance{b.log_between(1e6, 3e7), 0.25, 250}
                           : kind < 0.6 ? card(b)
                           : kind < 0.8 ? wood(b)
                                        : stuffing(b);
  const int bar_part = b.new_part(), thread_part = b.new_part(), figure_part = b.new_part();
  const float high = 1.2f * length;
  const Vec3f colour = b.any_colour();
  for (int k = b.count(1, 2); k > 0; --k) {
    const Vec3f out = 0.5f * length * Vec3f(b.outward(0)), middle(0, 0, high);
    b.add(Tube(straight(middle - out, middle + out), radius, radius), bar_part, b.any_colour(), bar);
    for (const float s : {-1.0f, 1.0f}) {
      const Vec3f end = middle + s * out, low = end - Vec3f(0, 0, length * metres(b.between(0.3, 0.8)));
      b.add(Tube(straight(end, low), 0.25f * radius, 0.25f * radius), thread_part, b.any_colour(), thread);
      b.add(Ellipsoid(low, length * Vec3f(0.1f, 0.03f, 0.08f)), figure_part, b.tint(colour, 0.2), figure);
    }
  }
  b.add(Tube(straight({0, 0, high}, {0, 0, 1.5f * length}), 0.25f * radius, 0.25f * radius), thread_part,
        b.any_colour(), thread);
}

void make_doll(ObjectBuilder& b) {
  const float r = metres(b.log_between(0.02, 0.08));
  const Substance hard = b.chance(0.4)   ? hard_ware(b)
                         : b.chance(0.5) ? plastic(b)
                                         : wood(b),
                  soft = b.chance(0.6) ? stuffing(b) : foam(b), dress = cloth(b),
                  hair = Substance{b.log_between(1e5, 2e7), 0.3, 300};
  const bool hollow = b.chance(0.5), hard_limbs = b.chance(0.6);
  const double cover = b.log_between(3, 100);
  const Vec3f skin = b.tint({0.85f, 0.68f, 0.55f}, 0.08), cloth_colour = b.any_colour();
  const int head = b.new_part(), body = b.new_part(), limb = b.new_part(), hair_part = b.new_part();
  b.add(
      Ellipsoid({0, 0, 2.2f * r}, Vec3f(0.8f, 0.6f, 1.3f) * r), body,
      [cloth_colour](const ShapePoint&) { return cloth_colour; },
      [=](const ShapePoint& p) { return stiffer(soft, p.across > 0.9f ? cover : 1); });
  b.add(Ellipsoid({0, 0, 4.3f * r}, Vec3f(0.85f, 0.9f, 1) * r, Mat3f::Identity(), hollow ? 0.12f * r : 0), head, skin,
        hard);
  b.add(Ellipsoid({0, -0.3f * r, 4.8f * r}, Vec3f(0.95f, 0.8f, 0.7f) * r), hair_part, b.any_colour(), hair);
  for (const float side : {-1.0f, 1.0f})
    for (const float low : {0.3f, 2.6f})
      b.add(Tube(straight({side * 0.5f * r, 0, (low + 0.9f) * r},
                          {side * (low > 1 ? 1.8f : 0.6f) * r, 0.2f * r, low * r}),
                 0.3f * r, 0.22f * r),
            limb, low > 1 ? skin : b.any_colour(), hard_limbs ? hard : stiffer(soft, 3));
  if (b.chance(0.7)) {
    const auto outer = [=](float s) { return r * (1.8f - 0.9f * s); };
    b.add(Lathe({0, 0, 0.6f * r}, Vec3f::UnitZ(), 1.8f * r, outer, [=](float s) { return outer(s) - 0.06f * r; }), body,
          cloth_colour, dress);
  }
}

void make_bag(ObjectBuilder& b) {
  const float wide = metres(b.log_between(0.1, 0.5)), deep = wide * metres(b.between(0.2, 0.5)),
              high = wide * metres(b.between(0.6, 1.2)), thick = wide * metres(b.between(0.006, 0.02));
  const Substance wall = b.chance(0.5) ? leather(b) : cloth(b), buckle = metal(b),
                  inside = b.chance(0.6) ? stuffing(b) : foam(b);
  const int wall_part = b.new_part(), buckle_part = b.new_part(), inside_part = b.new_part();
  const Vec3f colour = b.any_colour();
  if (b.chance(0.5))
    b.add(Cuboid({0, 0, 0.45f * high}, {0.45f * wide, 0.42f * deep, 0.42f * high}), inside_part, colour, inside);
  for (const float y : {-0.5f, 0.5f})
    add_panel(b, wall_part, {0, y * deep, 0}, {0, y * deep, high}, Vec3f::UnitX(), 0.5f * wide, 0.47f * wide, thick,
              colour, wall);
  for (const float x : {-0.5f, 0.5f})
    add_panel(b, wall_part, {x * wide, 0, 0}, {x * wide, 0, high}, Vec3f::UnitY(), 0.5f * deep, 0.4f * deep, thick,
              colour, wall);
  b.add(Cuboid({0, 0, thick}, {0.5f * wide, 0.5f * deep, thick}), wall_part, colour, stiffer(wall, 3));
  b.add(Tube(curve({0.3f * wide, 0, high}, Vec3f(0.2f, 0, 1), 1.1f * wide, Vec3f(-1, 0, -1), 3.0f), 1.5f * thick,
             1.5f * thick),
        wall_part, b.tint(colour), stiffer(wall, 2));
  for (int k = b.count(0, 3); k > 0; --k)
    b.add(Cuboid({metres(b.between(-0.4, 0.4)) * wide, -0.5f * deep, metres(b.between(0.3, 0.9)) * high},
                 wide * Vec3f(0.05f, 0.012f, 0.035f)),
          buckle_part, b.tint({0.7f, 0.6f, 0.35f}), buckle);
}

}  // namespace

std::vector<ObjectFamily> mixed_families() {
  return {{"assembly", FamilyRole::kTrain, make_assembly},
          {"sailboat", FamilyRole::kTrain, make_sailboat},
          {"tool", FamilyRole::kTrain, make_tool},
          {"vehicle", FamilyRole::kTrain, make_vehicle},
          {"basket", FamilyRole::kTrain, make_basket},
          {"sweet", FamilyRole::kTrain, make_sweet},
          {"mobile", FamilyRole::kTrain, make_mobile},
          {"doll", FamilyRole::kTrain, make_doll},
          {"bag", FamilyRole::kTrain, make_bag}};
}

}  // namespace pliant
