// Potted flowers: carnation, rose, tulip.

#include <cmath>

#include "app/demo/kinds/kind_builder.h"
#include "app/demo/kinds/kinds.h"

namespace pliant {
namespace {

const Vec3d kCarnations[] = {{0.80, 0.16, 0.22}, {0.86, 0.50, 0.62}, {0.88, 0.80, 0.76}, {0.62, 0.16, 0.40}};
const Vec3d kRoses[] = {{0.72, 0.10, 0.16}, {0.86, 0.60, 0.56}, {0.88, 0.74, 0.34}, {0.86, 0.82, 0.74}};
const Vec3d kTulips[] = {{0.82, 0.22, 0.16}, {0.86, 0.68, 0.18}, {0.60, 0.22, 0.50}, {0.86, 0.46, 0.40}};
const Vec3d kGreens[] = {{0.24, 0.46, 0.22}, {0.30, 0.50, 0.26}, {0.26, 0.44, 0.32}};

/// Materials that potted flowers share, in this order.
struct FlowerMaterials {
  int stem, leaf, petal;
};
FlowerMaterials flower_materials(KindBuilder& b) {
  FlowerMaterials m;
  m.stem = b.material("stem", {1.0e5, 0.27, 650}, {1.8e5, 0.33, 800},
                      "a herb's stem, 4 mm across with E = 130 to 230 MPa (Niklas 1992), has the bending stiffness E I "
                      "of this one, six times as thick, with 100 to 180 kPa");
  m.leaf = b.material("leaf", {3.0e4, 0.27, 300}, {6.0e4, 0.33, 450},
                      "a blade 0.5 mm thick with E = 20 to 40 MPa (Onoda et al. 2011) has the bending stiffness E t^3 "
                      "of this one, nine times as thick, with 30 to 60 kPa");
  m.petal = b.material("petal", {5.0e3, 0.25, 200}, {1.2e4, 0.33, 300},
                       "a petal 0.4 mm thick with E = 3 to 7 MPa (estimate) has the bending stiffness E t^3 of this "
                       "one, eight times as thick, with 5 to 12 kPa");
  return m;
}

/// A ring of petals around the head's axis.
struct PetalRing {
  int count;
  double rise;    ///< of a petal's start over the plane across the axis [rad]
  double height;  ///< of the roots along the axis
  double offset;  ///< of the roots from the axis
  double phase;   ///< in petals
};
void add_ring(KindBuilder& b, int material, const Blade& blade, const PetalRing& ring, const Vec3d& centre,
              const Vec3d& axis, const std::function<Paint()>& paint) {
  const Vec3d first = axis.unitOrthogonal(), second = axis.cross(first);
  for (int k = 0; k < ring.count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + ring.phase + b.between(-0.06, 0.06)) / ring.count;
    const double rise = ring.rise + b.between(-0.08, 0.08);
    const Vec3d out = std::cos(angle) * first + std::sin(angle) * second;
    b.add(material, make_blade(blade),
          blade_pose(centre + ring.height * axis + ring.offset * out, std::cos(rise) * out + std::sin(rise) * axis,
                     std::sin(rise) < 0.999 ? axis : Vec3d(-out)),
          paint());
  }
}

/// Pairs of leaves that droop from a stem.
void add_leaves(KindBuilder& b, int material, const Stem& stem, const Blade& blade, int count, double low, double high,
                double rise, const Vec3d& green) {
  for (int k = 0; k < count; ++k) {
    // Leaves stand to the sides, where they do not hide the stem.
    const double angle = std::numbers::pi * (k % 2) + b.between(-0.5, 0.5), up = rise + b.between(-0.15, 0.15);
    const double share = low + (high - low) * k / std::max(1, count - 1);
    const Vec3d out(std::cos(angle), std::sin(angle), 0);
    b.add(material, make_blade(blade),
          blade_pose(stem.at(share), std::cos(up) * out + std::sin(up) * Vec3d::UnitZ(), Vec3d::UnitZ()),
          b.paint(Paint::Kind::kVeined, green, 1.35 * green, 0.016));
  }
}

}  // namespace

DemoObject make_carnation(uint64_t seed) {
  KindBuilder b("carnation", seed);
  const double radius = b.between(0.0125, 0.0140), pot_height = b.between(0.070, 0.080);
  const double pin = b.add_pot(0.058, pot_height, radius);
  const FlowerMaterials m = flower_materials(b);
  const int calyx = b.material("calyx", {3.0e4, 0.27, 500}, {6.0e4, 0.33, 700},
                               "the closed base of the blossom, softer than the stem and as moist");
  const Vec3d petal = b.colour(kCarnations), green = b.colour(kGreens);

  const double lean = b.between(-0.10, 0.10);
  const Stem stem = make_stem({0, 0, pin - 0.035}, {std::sin(lean), -0.06, std::cos(lean)}, b.between(0.165, 0.180),
                              {lean > 0 ? -1.0 : 1.0, 0, 0}, b.between(0.05, 0.25));
  const Vec3d top = stem.spine.back(), axis = stem.direction(1);
  b.add(m.stem, make_rod(stem.spine, radius, 0.85 * radius), b.paint(Paint::Kind::kBands, 0.9 * green, green));
  b.add(calyx, make_rod({top - 0.012 * axis, top + 0.026 * axis}, 0.011, 0.021), b.paint(1.1 * green));
  add_leaves(b, m.leaf, stem,
             {b.between(0.085, 0.105), 0.0085, 0.0022, -0.9,
              [](double u) { return 0.55 + 0.45 * std::cos(3 * (u - 0.3)) * (1 - 0.5 * u * u); }},
             4, 0.30, 0.62, 0.75, 0.92 * green + Vec3d(0.02, 0.03, 0.06));

  // Petals are fans whose edges are ruffled, the more the farther out.
  const double ruffle = b.between(0.0030, 0.0045);
  const Vec3d centre = top + 0.016 * axis, edge = (1.18 * petal).cwiseMin(0.95);
  const auto paint = [&] { return b.paint(Paint::Kind::kGraded, 0.72 * petal, edge, 0.048); };
  b.add(m.petal, make_ellipsoid(Vec3d(0.018, 0.016, 0.016)), blade_pose(centre, axis, axis.unitOrthogonal()), paint());
  const auto fan = [&](double length, double half_width, double waves, double bend) {
    return Blade{length,
                 half_width,
                 0.0017,
                 bend,
                 [](double u) { return 0.32 + 0.68 * std::pow(u, 0.8); },
                 [=](double u, double across) { return ruffle * u * u * std::sin(waves * across + 2 * u); }};
  };
  add_ring(b, m.petal, fan(0.048, 0.0210, 7, -0.5), {8, 0.30, 0, 0.002, 0}, centre, axis, paint);
  add_ring(b, m.petal, fan(0.045, 0.0195, 8, -0.3), {7, 0.70, 0.002, 0.002, 0.5}, centre, axis, paint);
  add_ring(b, m.petal, fan(0.042, 0.0170, 9, 0.1), {6, 1.12, 0.003, 0.002, 0.25}, centre, axis, paint);
  b.object.tip = centre + 0.008 * axis;
  b.object.tip_radius = 0.032;
  return b.finish();
}

DemoObject make_rose(uint64_t seed) {
  KindBuilder b("rose", seed);
  const double radius = b.between(0.0125, 0.0140);
  const double pin = b.add_pot(0.056, b.between(0.072, 0.084), radius);
  const FlowerMaterials m = flower_materials(b);
  const int hip = b.material("hip", {3.0e4, 0.27, 500}, {6.0e4, 0.33, 700},
                             "the receptacle below the petals, softer than the stem and as moist");
  const Vec3d petal = b.colour(kRoses), green = b.colour(kGreens);

  const double lean = b.between(-0.12, 0.12);
  const Stem stem = make_stem({0, 0, pin - 0.035}, {std::sin(lean), -0.08, std::cos(lean)}, b.between(0.160, 0.180),
                              {lean > 0 ? -1.0 : 1.0, -0.3, 0}, b.between(0.10, 0.30));
  const Vec3d top = stem.spine.back(), axis = stem.direction(1);
  b.add(m.stem, make_rod(stem.spine, radius, 0.85 * radius),
        b.paint(Paint::Kind::kSpots, 0.85 * green, {0.42, 0.30, 0.20}, 0.03));
  b.add(hip, make_ellipsoid({0.016, 0.017, 0.017}), blade_pose(top, axis, axis.unitOrthogonal()),
        b.paint(1.05 * green));
  // Leaflets are broad and end in a point.
  add_leaves(b, m.leaf, stem,
             {b.between(0.070, 0.085), 0.020, 0.0024, -0.55,
              [](double u) {
                return 0.16 + 0.84 * std::sqrt(std::sin(std::numbers::pi * (0.06 + 0.90 * u))) * (1 - 0.25 * u);
              },
              [](double u, double across) { return 0.006 * across * across * std::sin(std::numbers::pi * u); }},
             3, 0.34, 0.66, 0.45, green);

  // Cupped petals in three rings about a closed heart: each ring opens more than the one inside of it.
  const Vec3d centre = top + 0.010 * axis;
  const Vec3d deep = 0.70 * petal, pale = (1.12 * petal).cwiseMin(0.95);
  const auto paint = [&] { return b.paint(Paint::Kind::kGraded, deep, pale, 0.058); };
  const auto cup = [](double length, double half_width, double bend, double roll) {
    return Blade{
        length,
        half_width,
        0.0018,
        bend,
        [](double u) { return 0.35 + 0.65 * std::sqrt(std::sin(std::numbers::pi * (0.10 + 0.78 * u))); },
        [=](double u, double across) { return roll * across * across * std::sqrt(u) - 0.006 * u * u * u * u; }};
  };
  b.add(m.petal, make_ellipsoid({0.028, 0.014, 0.014}), blade_pose(centre + 0.022 * axis, axis, axis.unitOrthogonal()),
        b.paint(deep));
  const double open = b.between(-0.1, 0.1);
  add_ring(b, m.petal, cup(0.058, 0.0280, 0.85, 0.013), {6, 0.35 + open, 0, 0.003, 0}, centre, axis, paint);
  add_ring(b, m.petal, cup(0.056, 0.0245, 0.75, 0.012), {5, 0.78 + open, 0.002, 0.003, 0.4}, centre, axis, paint);
  add_ring(b, m.petal, cup(0.050, 0.0205, 0.55, 0.011), {4, 1.15, 0.004, 0.004, 0.7}, centre, axis, paint);
  b.object.tip = centre + 0.018 * axis;
  b.object.tip_radius = 0.034;
  return b.finish();
}

DemoObject make_tulip(uint64_t seed) {
  KindBuilder b("tulip", seed);
  const double radius = b.between(0.0120, 0.0135);
  const double pin = b.add_pot(0.054, b.between(0.068, 0.080), radius);
  const FlowerMaterials m = flower_materials(b);
  const Vec3d petal = b.colour(kTulips), green = b.colour(kGreens);

  const double lean = b.between(-0.10, 0.10);
  const Stem stem = make_stem({0, 0, pin - 0.035}, {std::sin(lean), -0.05, std::cos(lean)}, b.between(0.170, 0.190),
                              {lean > 0 ? -1.0 : 1.0, 0, 0}, b.between(0.05, 0.30));
  const Vec3d top = stem.spine.back(), axis = stem.direction(1);
  b.add(m.stem, make_rod(stem.spine, radius, 0.85 * radius), b.paint(Paint::Kind::kBands, 1.05 * green, 1.15 * green));
  // Two long leaves sheathe the stem's foot.
  for (int k = 0; k < 2; ++k) {
    const double angle = std::numbers::pi * k + b.between(-0.4, 0.4), rise = b.between(1.10, 1.25);
    const Vec3d out(std::cos(angle), std::sin(angle), 0);
    const Blade leaf{
        b.between(0.135, 0.160),
        0.019,
        0.0026,
        -b.between(0.7, 1.1),
        [](double u) { return 0.45 + 0.55 * std::sqrt(std::sin(std::numbers::pi * (0.12 + 0.84 * u))) - 0.35 * u * u; },
        [](double u, double across) { return 0.009 * across * across * (1 - u); }};
    b.add(m.leaf, make_blade(leaf),
          blade_pose(Vec3d(0, 0, pin + 0.006) + 0.6 * radius * out,
                     std::cos(rise) * out + std::sin(rise) * Vec3d::UnitZ(), Vec3d(-out)),
          b.paint(Paint::Kind::kGraded, 0.90 * green, (1.15 * green + Vec3d(0.02, 0.05, 0.06)).cwiseMin(0.9), 0.12));
  }
  // Three inner and three outer petals close to an egg.
  const double length = b.between(0.082, 0.092), width = b.between(0.0245, 0.0270), close = b.between(1.55, 1.90);
  const Vec3d pale = (1.10 * petal + Vec3d(0.06, 0.06, 0.02)).cwiseMin(0.95);
  const auto paint = [&] { return b.paint(Paint::Kind::kGraded, pale, 0.88 * petal, 0.06); };
  const Blade blade{length,
                    width,
                    0.0019,
                    close,
                    [](double u) { return 0.30 + 0.70 * std::sqrt(std::sin(std::numbers::pi * (0.05 + 0.88 * u))); },
                    [](double u, double across) {
                      return 0.009 * across * across * std::sin(std::numbers::pi * std::min(1.0, 0.2 + u));
                    }};
  const Vec3d centre = top + 0.004 * axis;
  b.add(m.petal, make_ellipsoid({0.012, 0.016, 0.016}), blade_pose(centre, axis, axis.unitOrthogonal()), b.paint(pale));
  add_ring(b, m.petal, blade, {3, 0.26, 0, 0.004, 0}, centre, axis, paint);
  add_ring(b, m.petal, blade, {3, 0.36, 0.001, 0.002, 0.5}, centre, axis, paint);
  b.object.tip = centre + 0.030 * axis;
  b.object.tip_radius = 0.036;
  return b.finish();
}

}  // namespace pliant
