// Made things: a hat whose brim is of knitted shells, and the cord of a telephone.

#include <cmath>

#include "app/demo/kinds/kind_builder.h"
#include "app/demo/kinds/kinds.h"

namespace pliant {
namespace {

const Vec3d kWools[] = {{0.78, 0.66, 0.46}, {0.44, 0.52, 0.66}, {0.70, 0.42, 0.40}, {0.52, 0.60, 0.44}};
const Vec3d kCords[] = {{0.30, 0.52, 0.50}, {0.76, 0.30, 0.24}, {0.82, 0.72, 0.46}, {0.40, 0.40, 0.46}};
const Vec3d kTelephones[] = {{0.60, 0.20, 0.18}, {0.26, 0.34, 0.36}, {0.78, 0.74, 0.62}};

std::vector<Vec3d> circle(double radius, double z) {
  std::vector<Vec3d> ring;
  constexpr int kPieces = 120;
  for (int i = 0; i <= kPieces + 2; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPieces;
    ring.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
  }
  return ring;
}

}  // namespace

DemoObject make_hat(uint64_t seed) {
  KindBuilder b("hat", seed);
  const int stand = b.fixed("stand");
  const int band =
      b.material("band", {3.0e4, 0.20, 200}, {6.0e4, 0.28, 300},
                 "wool knitted tightly in several layers: a few times as stiff as the shells that hang on it");
  const int shell = b.material("shell", {8.0e3, 0.20, 150}, {2.0e4, 0.28, 220},
                               "hand-knitted wool in bending: an E t^3 of some mN m over this thickness is 8 to 20 kPa "
                               "(order of magnitude of Kawabata's bending tests)");
  const Vec3d wool = b.colour(kWools), trim = b.colour(kWools);
  const double head = b.between(0.070, 0.076), level = b.between(0.150, 0.165);
  // A hat stand with a felt crown on it.
  b.add(stand,
        make_turned({{0, 0},
                     {0.066, 0},
                     {0.068, 0.004},
                     {0.064, 0.012},
                     {0.022, 0.020},
                     {0.016, 0.034},
                     {0.016, level - 0.04},
                     {0.030, level - 0.024},
                     {0, level - 0.022}}),
        b.paint(Paint::Kind::kBands, {0.46, 0.32, 0.22}, {0.38, 0.25, 0.17}));
  b.add(stand,
        make_turned({{0, level - 0.030},
                     {head - 0.006, level - 0.030},
                     {head, level - 0.022},
                     {head, level + 0.030},
                     {0.94 * head, level + 0.054},
                     {0.78 * head, level + 0.072},
                     {0.45 * head, level + 0.084},
                     {0, level + 0.087}}),
        b.paint(Paint::Kind::kBands, 0.82 * wool, 0.74 * wool));
  b.add(band, make_rod(circle(head + 0.004, level), 0.0085, 0.0085), b.paint(Paint::Kind::kBands, trim, 0.8 * trim));
  // Fans with ribs lie around the band like shingles.
  const int count = 13 + static_cast<int>(b.between(0, 4));
  const double length = b.between(0.058, 0.066), fall = b.between(0.05, 0.25), phase = b.between(0, 1);
  const double root = head + 0.004, half = 1.18 * std::numbers::pi * (root + length) / count;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + phase) / count, dip = fall + b.between(-0.03, 0.03);
    const Vec3d out(std::cos(angle), std::sin(angle), 0), around(-std::sin(angle), std::cos(angle), 0);
    const Vec3d along = std::cos(dip) * out - std::sin(dip) * Vec3d::UnitZ();
    const Vec3d up = (out.cross(around) + 0.11 * around).normalized();
    const Blade fan{length,
                    half,
                    0.0032,
                    0.15,
                    [](double u) { return 0.60 + 0.40 * std::pow(u, 0.8) - 0.22 * std::pow(u, 8); },
                    [](double u, double across) { return 0.0012 * u * std::cos(5 * std::numbers::pi * across); }};
    b.add(shell, make_blade(fan), blade_pose(Vec3d(0, 0, level) + root * out, along, up),
          b.paint(Paint::Kind::kKnit, k % 2 ? wool : Vec3d(0.88 * wool), trim, 0.0072));
  }
  b.object.pins = {Region::sphere({0, 0, level}, head + 0.006)};
  // The brim surrounds its pin and the crown, so that a jolt pushes the front of it alone.
  b.object.jolted = Region::cylinder({0, -(head + 0.013), level}, {0, -(root + length + 0.010), level}, 0.130);
  b.object.tip = Vec3d(0, -(root + 0.80 * length), level - 0.8 * length * fall);
  b.object.tip_radius = 0.024;
  b.object.push = Vec3d(0.25, 0.0, -0.97).normalized();
  b.object.pull = Vec3d(0.10, -0.30, 0.95).normalized();
  return b.finish();
}

DemoObject make_cord(uint64_t seed) {
  KindBuilder b("cord", seed);
  const int telephone = b.fixed("telephone");
  const int cord =
      b.material("cord", {1.0e5, 0.30, 950}, {2.0e5, 0.36, 1100},
                 "a soft gel, so that the coil's rate G d^4 / (8 D^3 n) of half a newton per metre is that of a "
                 "thinner cord of PVC");
  const Vec3d colour = b.colour(kCords), body = b.colour(kTelephones);
  const double top = b.between(0.285, 0.305), wire = b.between(0.0080, 0.0088), coil = b.between(0.0240, 0.0270);
  const double turns = 4.5 + 0.5 * static_cast<int>(b.between(0, 3)), box = 0.044;
  const Vec3d dark(0.24, 0.22, 0.22);
  // The set below, with its dial, and an arm above from which the handset hangs.
  b.add(telephone, make_cuboid({0.052, 0.042, box / 2}), standing(0, 0.008, box / 2, 0), b.paint(body));
  b.add(telephone, make_ellipsoid({0.020, 0.004, 0.018}), standing(0, -0.034, 0.55 * box, 0),
        b.paint(Paint::Kind::kBands, {0.80, 0.78, 0.72}, dark));
  const double back = 0.062;
  b.add(telephone, make_cuboid({0.040, 0.020, 0.006}), standing(0, back, 0.006, 0), b.paint(dark));
  b.add(telephone, make_rod({{0, back, 0.006}, {0, back, top + 0.012}}, 0.009, 0.008), b.paint(dark));
  b.add(telephone, make_rod({{0, back + 0.004, top + 0.006}, {0, -0.022, top + 0.006}}, 0.008, 0.008), b.paint(dark));
  b.add(telephone, make_rod({{-0.052, -0.004, top + 0.016}, {0.052, -0.004, top + 0.016}}, 0.011, 0.011),
        b.paint(body));
  for (const double side : {-1.0, 1.0})
    b.add(telephone, make_ellipsoid({0.020, 0.018, 0.014}), standing(0.052 * side, -0.004, top + 0.008, 0),
          b.paint(body));

  // The coil comes out of the box on its axis and goes into the arm likewise.
  const double low = box - 0.010, span = top - low;
  std::vector<Vec3d> spine;
  constexpr int kPieces = 400;
  const double phase = b.between(0, 2 * std::numbers::pi);
  for (int i = 0; i <= kPieces; ++i) {
    const double u = static_cast<double>(i) / kPieces, inward = std::min({1.0, u / 0.10, (1 - u) / 0.10});
    const double radius = coil * std::pow(std::sin(0.5 * std::numbers::pi * inward), 2),
                 angle = phase + 2 * std::numbers::pi * turns * u;
    spine.emplace_back(radius * std::cos(angle), radius * std::sin(angle), low + span * u);
  }
  b.add(cord, make_rod(spine, wire, wire), b.paint(Paint::Kind::kGraded, colour, 0.8 * colour, 0.02));
  b.object.pins = {Region::sphere({0, 0, box - 0.006}, 0.018), Region::sphere({0, 0, top}, 0.018)};
  b.object.tip = Vec3d(0, 0, 0.5 * (low + top));
  b.object.tip_radius = coil + 0.010;
  b.object.pull = Vec3d(0.8, -0.3, -0.5).normalized();
  return b.finish();
}

}  // namespace pliant
