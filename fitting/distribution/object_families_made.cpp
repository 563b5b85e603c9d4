#include <Eigen/Geometry>
#include <cmath>

#include "fitting/distribution/object_families.h"

namespace pliant {
namespace {

Substance frame(ObjectBuilder& b) {
  const double kind = b.between(0, 1);
  return kind < 0.5 ? wood(b) : kind < 0.8 ? metal(b) : plastic(b);
}

void make_table(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.3, 0.9)), half = height * metres(b.between(0.5, 1.1)),
              deep = half * metres(b.between(0.5, 1));
  const float top = height * metres(b.between(0.03, 0.08)), leg = height * metres(b.between(0.02, 0.06));
  const Substance legs = frame(b),
                  board = b.chance(0.6)   ? wood(b)
                          : b.chance(0.5) ? hard_ware(b)
                                          : plastic(b),
                  fabric = cloth(b);
  const int board_part = b.new_part(), leg_part = b.new_part(), cover = b.new_part();
  const Vec3f leg_colour = b.any_colour();
  for (const float x : {-0.9f, 0.9f})
    for (const float y : {-0.9f, 0.9f})
      b.add(Tube(straight({x * half, y * deep, 0}, {x * half, y * deep, height}), leg, leg), leg_part, leg_colour,
            legs);
  b.add(Cuboid({0, 0, height}, {half, deep, top}), board_part, b.any_colour(), board);
  if (b.chance(0.4)) {
    const Vec3f colour = b.any_colour();
    const float thick = 0.3f * top;
    b.add(Cuboid({0, 0, height + top + 0.5f * thick}, {half, deep, 0.5f * thick}), cover, colour, fabric);
    for (const float y : {-1.0f, 1.0f})
      b.add(Cuboid({0, y * deep, 0.85f * height}, {half, 0.5f * thick, 0.15f * height}), cover, colour, fabric);
  }
}

void make_stool(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.3, 0.8)), radius = height * metres(b.between(0.25, 0.5)),
              leg = height * metres(b.between(0.02, 0.05));
  const float seat = height * metres(b.between(0.08, 0.22));
  const Substance legs = frame(b), soft = foam(b), cover = {soft.young * b.log_between(5, 300), 0.35, 300},
                  board = wood(b);
  const int leg_part = b.new_part(), seat_part = b.new_part(), board_part = b.new_part();
  const Vec3f leg_colour = b.any_colour(), colour = b.any_colour();
  const int count = b.count(3, 4);
  for (int k = 0; k < count; ++k) {
    const Vec3f out = radius * across_axis(Vec3f::UnitZ(), 6.2831853f * metres(k) / metres(count));
    b.add(Tube(straight(out, 0.8f * out + Vec3f(0, 0, height)), leg, leg), leg_part, leg_colour, legs);
  }
  b.add(Lathe({0, 0, height}, Vec3f::UnitZ(), 0.25f * seat, [=](float) { return radius; }), board_part, leg_colour,
        board);
  b.add(
      Lathe({0, 0, height + 0.25f * seat}, Vec3f::UnitZ(), seat,
            [=](float s) { return radius * std::sqrt(std::max(0.05f, 1 - 0.4f * s * s)); }),
      seat_part, [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) { return p.depth < 0.1f * seat ? cover : soft; });
}

void make_lamp(ObjectBuilder& b) {
  const float height = metres(b.log_between(0.2, 1.6)), radius = height * metres(b.between(0.1, 0.25)),
              pole = height * metres(b.between(0.01, 0.03));
  const Substance foot = b.chance(0.6) ? metal(b) : hard_ware(b), rod = frame(b);
  const bool paper = b.chance(0.7);
  const Substance shade = paper ? Substance{b.log_between(5e7, 2e9), 0.3, b.between(300, 800)} : plastic(b);
  const int foot_part = b.new_part(), rod_part = b.new_part(), shade_part = b.new_part();
  const float tall = height * metres(b.between(0.2, 0.4)), tip = radius * metres(b.between(0.4, 1));
  b.add(Tube(straight({0, 0, 0}, {0, 0, height - 0.5f * tall}), pole, pole), rod_part, b.any_colour(), rod);
  b.add(Lathe(Vec3f::Zero(), Vec3f::UnitZ(), 0.04f * height, [=](float s) { return radius * (1 - 0.4f * s); }),
        foot_part, b.any_colour(), foot);
  const auto outer = [=](float s) { return 1.3f * (radius + (tip - radius) * s); };
  b.add(Lathe({0, 0, height - tall}, Vec3f::UnitZ(), tall, outer, [=](float s) { return 0.97f * outer(s); }),
        shade_part, b.any_colour(), shade);
}

void make_brush(ObjectBuilder& b) {
  const float length = metres(b.log_between(0.1, 1.4)), radius = length * metres(b.between(0.01, 0.04)),
              head = radius * metres(b.between(1.5, 6));
  const Substance handle = frame(b), block = b.chance(0.5) ? wood(b) : plastic(b);
  // Bristles smeared out with the air between them: a few percent of their E along, far less across.
  const double bristle = b.log_between(1e5, 2e7), tip = b.log_between(0.1, 0.8), tall = b.between(0.08, 0.2) * length;
  const bool upside = b.chance(0.4);
  const int handle_part = b.new_part(), block_part = b.new_part(), hair = b.new_part();
  const auto z = [=](double x) { return metres(upside ? length + tall - x : x); };
  const Vec3f colour = b.any_colour();
  b.add(Tube(straight({0, 0, z(tall)}, {0, 0, z(length + tall)}), radius, radius), handle_part, b.any_colour(), handle);
  b.add(Lathe({0, 0, z(tall)}, {0, 0, upside ? -1.0f : 1.0f}, 0.04f * length, [=](float) { return head; }), block_part,
        b.any_colour(), block);
  b.add(
      Lathe({0, 0, z(tall)}, {0, 0, upside ? 1.0f : -1.0f}, metres(tall),
            [=](float s) { return head * (1 + 0.25f * s); }),
      hair, [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) {
        return Substance{bristle * std::pow(tip, p.along), 0.2, 250};
      });
}

void make_balloon(ObjectBuilder& b) {
  // Air under pressure in a skin: as a solid about as stiff as the pressure, the skin a rubber.
  const float radius = metres(b.log_between(0.05, 0.25)), length = radius * metres(b.between(2, 6));
  const double air = b.log_between(1e3, 2e4), skin = b.log_between(5e5, 5e6);
  const Substance twine = cloth(b);
  const Vec3f colour = b.any_colour();
  const int ball = b.new_part(), string = b.new_part(), knot = b.new_part();
  b.add(Tube(curve(Vec3f::Zero(), b.outward(0.98), length, b.outward(0), metres(b.between(0, 0.7))), 0.012f * radius,
             0.012f * radius),
        string, b.any_colour(), stiffer(twine, 5));
  b.add(
      Ellipsoid({0, 0, length + radius}, Vec3f(1, 1, 1.2f) * radius), ball,
      [colour](const ShapePoint&) { return colour; },
      [=](const ShapePoint& p) {
        return p.across > 0.93f ? Substance{skin, 0.48, 200} : Substance{air, 0.1, 10};
      });
  b.add(Ellipsoid({0, 0, length - 0.25f * radius}, Vec3f::Constant(0.1f * radius)), knot, colour,
        Substance{skin, 0.48, 950});
}

void make_book(ObjectBuilder& b) {
  // Leaves that slide on each other are soft as a block; boards and spine hold it.
  const float width = metres(b.log_between(0.08, 0.25)), thick = width * metres(b.between(0.1, 0.4)),
              tall = 1.4f * width;
  const double block = b.log_between(1e6, 1e8);
  const Substance board = {b.log_between(3e8, 3e9), 0.3, b.between(600, 900)};
  const Vec3f colour = b.any_colour(), paper = b.tint({0.9f, 0.87f, 0.78f}, 0.04);
  const bool stands = b.chance(0.5);
  Mat3f axes = Mat3f::Identity();
  if (stands) {
    axes.col(0) = Vec3f::UnitZ();
    axes.col(1) = Vec3f::UnitX();
    axes.col(2) = Vec3f::UnitY();
  }
  const Vec3f centre(0, 0, stands ? 0.5f * tall : 0.5f * thick);
  const int inside = b.new_part(), cover = b.new_part();
  b.add(Cuboid(centre, Vec3f(0.48f * tall, 0.48f * width, 0.45f * thick), axes), inside, paper,
        Substance{block, 0.2, 800});
  for (const float side : {-1.0f, 1.0f})
    b.add(Cuboid(centre + side * 0.48f * thick * axes.col(2),
                 Vec3f(0.5f * tall, 0.5f * width, 0.03f * thick + 0.004f * width), axes),
          cover, colour, board);
  b.add(Cuboid(centre + 0.5f * width * axes.col(1), Vec3f(0.5f * tall, 0.015f * width, 0.5f * thick), axes), cover,
        colour, stiffer(board, 0.5));
}

}  // namespace

std::vector<ObjectFamily> made_families() {
  return {{"table", FamilyRole::kTrain, make_table},     {"brush", FamilyRole::kTrain, make_brush},
          {"balloon", FamilyRole::kTrain, make_balloon}, {"book", FamilyRole::kTrain, make_book},
          {"lamp", FamilyRole::kValidate, make_lamp},    {"stool", FamilyRole::kTest, make_stool}};
}

}  // namespace pliant
