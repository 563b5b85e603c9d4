// Leaf plants.

#include <cmath>

#include "app/demo/kinds/kind_builder.h"
#include "app/demo/kinds/kinds.h"

namespace pliant {
namespace {

const Vec3d kBlades[] = {{0.12, 0.36, 0.20}, {0.18, 0.40, 0.16}, {0.14, 0.32, 0.26}};

/// Half width of an arrowhead: two lobes behind the stalk, widest before its first third, then a long point.
double arrowhead(double u) {
  const double lobe = 0.62 + 0.38 * std::sin(std::numbers::pi * std::min(1.0, u / 0.44));
  return u < 0.22 ? lobe : lobe * std::pow(std::max(0.0, (1 - u) / 0.78), 0.75) + 0.02;
}

}  // namespace

DemoObject make_alocasia(uint64_t seed) {
  KindBuilder b("alocasia", seed);
  const double pin = b.add_pot(0.060, b.between(0.070, 0.082), 0.02);
  const int stalk =
      b.material("stalk", {6.0e4, 0.27, 500}, {1.2e5, 0.33, 700},
                 "a stalk 5 mm across with E = 20 to 40 MPa (Niklas 1992) has the bending stiffness E I of "
                 "this one, four times as thick, with 60 to 120 kPa");
  const int blade =
      b.material("blade", {3.0e4, 0.27, 250}, {6.0e4, 0.33, 400},
                 "a blade 0.6 mm thick with E = 20 to 40 MPa (Onoda et al. 2011) has the bending stiffness "
                 "E t^3 of this one, nine times as thick, with 30 to 60 kPa");
  const Vec3d green = b.colour(kBlades), vein(0.70, 0.78, 0.56);
  const Vec3d purple(0.34, 0.22, 0.26);
  // The foot from which the stalks come, mostly in the soil.
  b.add(stalk, make_ellipsoid({0.018, 0.018, 0.022}), standing(0, 0, pin - 0.012, 0),
        b.paint(Paint::Kind::kBands, purple, 0.7 * purple));
  const int count = 4;
  const double first = b.between(-0.3, 0.3);
  for (int k = 0; k < count; ++k) {
    // The tallest leaf stands to the front; the others around it, lower ones more outwards.
    const double angle = -0.5 * std::numbers::pi + first + 2 * std::numbers::pi * k / count + b.between(-0.2, 0.2);
    const Vec3d out(std::cos(angle), std::sin(angle), 0);
    const double rise = k == 0 ? 1.42 : b.between(0.95, 1.2),
                 length = k == 0 ? b.between(0.170, 0.185) : b.between(0.115, 0.15);
    const Stem stem =
        make_stem(Vec3d(0, 0, pin - 0.012) + 0.008 * out, std::cos(rise) * out + std::sin(rise) * Vec3d::UnitZ(),
                  length, out, b.between(0.25, 0.45));
    b.add(stalk, make_rod(stem.spine, 0.0105, 0.0080),
          b.paint(Paint::Kind::kBands, 0.9 * green + 0.3 * purple, purple));
    const double size = (k == 0 ? 1.0 : b.between(0.80, 0.92)) * b.between(0.115, 0.125);
    const Vec3d top = stem.spine.back();
    const double droop = k == 0 ? b.between(0.7, 0.9) : b.between(0.5, 0.9);
    const Vec3d along = std::cos(droop) * out - std::sin(droop) * Vec3d::UnitZ();
    const Blade leaf{size, 0.42 * size, 0.0026, -b.between(0.3, 0.6), arrowhead, [=](double u, double across) {
                       return 0.005 * std::abs(across) + 0.0016 * std::sin(9 * u + 2) * across * across;
                     }};
    b.add(blade, make_blade(leaf), blade_pose(top - 0.26 * size * along, along, Vec3d::UnitZ()),
          b.paint(Paint::Kind::kVeined, green, vein, 0.020));
    if (k == 0) {
      b.object.tip = top + 0.15 * size * along;
      b.object.tip_radius = 0.024;
    }
  }
  return b.finish();
}

}  // namespace pliant
