// Soft things: jelly, cloth, and a composite of stiff and soft.

#include <cmath>

#include "app/demo/kinds/kind_builder.h"
#include "app/demo/kinds/kinds.h"

namespace pliant {
namespace {

const Vec3d kJellies[] = {{0.74, 0.14, 0.20}, {0.82, 0.50, 0.12}, {0.30, 0.62, 0.26}, {0.52, 0.20, 0.52}};
const Vec3d kCloths[] = {{0.66, 0.20, 0.22}, {0.22, 0.34, 0.56}, {0.84, 0.76, 0.56}, {0.24, 0.46, 0.36}};
const Vec3d kFoams[] = {{0.86, 0.50, 0.40}, {0.84, 0.74, 0.36}, {0.56, 0.70, 0.50}};
const Vec3d kBoards[] = {{0.26, 0.40, 0.62}, {0.40, 0.30, 0.50}, {0.24, 0.50, 0.50}};
const Vec3d kPlates[] = {{0.84, 0.83, 0.80}, {0.62, 0.74, 0.82}, {0.82, 0.76, 0.62}};

}  // namespace

DemoObject make_jelly(uint64_t seed) {
  KindBuilder b("jelly", seed);
  const int plate = b.fixed("plate");
  const int jelly = b.material("jelly", {2.5e3, 0.42, 1030}, {6.0e3, 0.45, 1080},
                               "a dessert gel of 3 to 6 % gelatin, a few kPa, that is nearly incompressible water");
  const int cherry = b.material("cherry", {2.0e4, 0.40, 900}, {4.0e4, 0.44, 1000},
                                "the flesh of a soaked fruit: about ten times as stiff as the gel that carries it");
  const Vec3d colour = b.colour(kJellies), glaze = b.colour(kPlates);
  const double foot = 0.008;
  // The plate, closed below as well.
  b.add(plate,
        make_turned({{0, 0},
                     {0.050, 0},
                     {0.062, 0.004},
                     {0.098, 0.015},
                     {0.099, 0.018},
                     {0.095, 0.018},
                     {0.060, foot},
                     {0, foot}}),
        b.paint(Paint::Kind::kBands, glaze, 0.8 * glaze));
  const double bottom = b.between(0.058, 0.066), top = bottom * b.between(0.62, 0.74), height = b.between(0.085, 0.105);
  const int flutes = 7 + static_cast<int>(b.between(0, 5));
  const double rise = foot + height;
  b.add(jelly,
        make_turned({{0, foot - 0.001},
                     {bottom - 0.004, foot - 0.001},
                     {bottom, foot + 0.003},
                     {top + 0.004, rise - 0.012},
                     {top - 0.002, rise - 0.005},
                     {top - 0.010, rise},
                     {0, rise + 0.002}},
                    flutes, b.between(0.04, 0.07)),
        b.paint(Paint::Kind::kSpots, colour, (1.3 * colour + Vec3d(0.05, 0.05, 0.05)).cwiseMin(0.95), 0.045));
  const double ball = b.between(0.015, 0.018);
  const Vec3d centre(b.between(-0.006, 0.006), b.between(-0.006, 0.006), rise + 0.6 * ball);
  b.add(cherry, make_ellipsoid(ball * Vec3d(1, 1, 0.92)), standing(centre.x(), centre.y(), centre.z(), 0),
        b.paint(Paint::Kind::kSpots, {0.62, 0.08, 0.10}, {0.82, 0.30, 0.28}, 0.03));
  b.object.pins = {Region::box({-0.11, -0.11, -0.01}, {0.11, 0.11, foot + 0.008})};
  b.object.tip = centre;
  b.object.tip_radius = 1.3 * ball;
  b.object.pull = Vec3d(0.9, 0, 0.436).normalized();
  return b.finish();
}

DemoObject make_cloth(uint64_t seed) {
  KindBuilder b("cloth", seed);
  const int rail = b.fixed("rail");
  const int cloth = b.material("cloth", {3.0e4, 0.20, 220}, {6.0e4, 0.30, 320},
                               "a quilted sheet: wool felt has some ten kPa across its loose layers (Ashby 2011 gives "
                               "flexible foams of this density 10 to 100 kPa)");
  const Vec3d colour = b.colour(kCloths), stripe = b.colour(kCloths), wood(0.50, 0.36, 0.24);
  const double top = b.between(0.285, 0.300), half = b.between(0.092, 0.104), turn = b.between(0.45, 0.75);
  // The rail is turned away from the front, so that what swings across it is seen from the side.
  const Eigen::Isometry3d pose = standing(0, 0, 0, turn);
  for (const double side : {-1.0, 1.0}) {
    const double x = side * (half + 0.020);
    b.add(rail, make_rod({{x, 0, 0.004}, {x, 0, top + 0.010}}, 0.008, 0.007), pose, b.paint(wood));
    b.add(rail, make_cuboid({0.012, 0.045, 0.006}), pose * standing(x, 0, 0.006, 0), b.paint(0.9 * wood));
  }
  b.add(rail, make_rod({{-half - 0.030, 0, top}, {half + 0.030, 0, top}}, 0.007, 0.007), pose, b.paint(1.1 * wood));

  // Folds hang down from the rail and grow; a cloth without any would be as limp as its thickness.
  const double depth = b.between(0.011, 0.015), folds = b.between(1.8, 2.6), phase = b.between(0, 6.28),
               length = b.between(0.215, 0.235);
  Sweep sheet;
  for (int i = 0; i <= 24; ++i) sheet.spine.emplace_back(0, 0, top + 0.006 - length * i / 24);
  sheet.side = Vec3d::UnitX();
  sheet.half = [=](double) { return half; };
  sheet.half_thickness = 0.0027;
  sheet.lift = [=](double u, double across) {
    const double grown = 0.25 + 0.75 * std::sin(0.5 * std::numbers::pi * std::min(1.0, 1.6 * u));
    return depth * grown * std::sin(2 * std::numbers::pi * folds * across + phase + 0.8 * u);
  };
  b.add(cloth, make_sweep(sheet), pose, b.paint(Paint::Kind::kPlaid, colour, stripe, 0.042));
  for (double x = -half; x <= half + 1e-9; x += half / 5)
    b.object.pins.push_back(Region::sphere(pose * Vec3d(x, 0, top + 0.002), 0.017));
  b.object.tip = pose * Vec3d(0, 0, top - 0.85 * length);
  b.object.tip_radius = 0.034;
  b.object.push = pose.linear() * Vec3d(0, -1, 0);
  b.object.pull = pose.linear() * Vec3d(0.1, -0.98, 0.17).normalized();
  return b.finish();
}

DemoObject make_composite(uint64_t seed) {
  KindBuilder b("composite", seed);
  const int base = b.fixed("base");
  const int foam = b.material("foam", {1.8e4, 0.25, 150}, {3.5e4, 0.32, 250},
                              "flexible polyurethane foam: tens of kPa at 150 to 250 kg/m^3 (Gibson and Ashby 1997)");
  const int hard =
      b.material("hard", {2.0e5, 0.28, 500}, {3.0e5, 0.34, 700},
                 "closed-cell foam board, about ten times as stiff as the foam: it hardly deforms beside it");
  const Vec3d soft = b.colour(kFoams), stiff = b.colour(kBoards);
  b.add(base, make_turned({{0, 0}, {0.060, 0}, {0.062, 0.004}, {0.062, 0.022}, {0.056, 0.028}, {0, 0.028}}),
        b.paint(Paint::Kind::kBands, {0.44, 0.32, 0.24}, {0.36, 0.26, 0.20}));
  const double column = b.between(0.0200, 0.0230), low = 0.024, plate = low + b.between(0.072, 0.084), thick = 0.016;
  const double wide = b.between(0.044, 0.050), neck = b.between(0.0160, 0.0180),
               high = plate + thick + b.between(0.046, 0.056);
  const double ball = b.between(0.027, 0.031);
  const auto speckled = [&] { return b.paint(Paint::Kind::kSpots, soft, 0.75 * soft, 0.018); };
  // A foam column carries a board, on which a thinner one carries a head.
  b.add(hard,
        make_turned({{0, plate},
                     {wide - 0.003, plate},
                     {wide, plate + 0.003},
                     {wide, plate + thick - 0.003},
                     {wide - 0.003, plate + thick},
                     {0, plate + thick}}),
        b.paint(Paint::Kind::kPlaid, stiff, 0.7 * stiff, 0.02));
  b.add(hard, make_ellipsoid({1.1 * ball, ball, ball}), standing(0, 0, high + 0.8 * ball, b.between(-0.5, 0.5)),
        b.paint(Paint::Kind::kBands, stiff, (1.3 * stiff).cwiseMin(0.95)));
  // A weight on the rim turns the board when it swings.
  const double angle = b.between(-0.6, 0.6);
  b.add(hard, make_ellipsoid({0.013, 0.013, 0.013}),
        standing(0.82 * wide * std::cos(angle), 0.82 * wide * std::sin(angle), plate + thick + 0.007, 0),
        b.paint({0.80, 0.66, 0.24}));
  b.add(foam, make_rod({{0, 0, low}, {0, 0, plate + 0.003}}, column, column), speckled());
  b.add(foam, make_rod({{0, 0, plate + thick - 0.003}, {0, 0, high + 0.25 * ball}}, neck, 0.9 * neck), speckled());
  b.object.pins = {Region::box({-0.07, -0.07, -0.01}, {0.07, 0.07, 0.036})};
  b.object.tip = Vec3d(0, 0, high + 0.8 * ball);
  b.object.tip_radius = 1.3 * ball;
  return b.finish();
}

}  // namespace pliant
