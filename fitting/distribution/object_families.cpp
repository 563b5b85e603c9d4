#include "fitting/distribution/object_families.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace pliant {

Substance wood(ObjectBuilder& b) {
  const double density = b.between(350, 800);  // E of wood rises about with its density
  return {1e10 * density / 550 * b.log_between(0.5, 1.5), b.between(0.28, 0.42), density};
}
Substance hard_ware(ObjectBuilder& b) {
  return {b.log_between(1e10, 7e10), b.between(0.17, 0.25), b.between(1800, 2600)};
}
Substance plastic(ObjectBuilder& b) { return {b.log_between(3e8, 3.5e9), b.between(0.35, 0.44), b.between(900, 1350)}; }
Substance metal(ObjectBuilder& b) {
  return {b.log_between(7e10, 2.1e11), b.between(0.27, 0.34), b.between(2700, 7900)};
}
Substance foam(ObjectBuilder& b) {
  const double density = b.log_between(18, 90);
  return {4e4 * std::pow(density / 30, 2) * b.log_between(0.4, 2), b.between(0.05, 0.35), density};
}
Substance cloth(ObjectBuilder& b) { return {b.log_between(1e6, 8e7), b.between(0.1, 0.4), b.between(250, 700)}; }
Substance soil(ObjectBuilder& b) { return {b.log_between(1e6, 3e7), b.between(0.2, 0.38), b.between(700, 1700)}; }

Substance stiffer(Substance s, double factor) {
  s.young *= factor;
  return s;
}

float add_pot(ObjectBuilder& b, float radius, float height) {
  const bool clay = b.chance(0.6);
  const Substance wall = clay ? hard_ware(b) : plastic(b), earth = soil(b);
  const float thick = radius * static_cast<float>(b.between(0.06, 0.14)),
              flare = static_cast<float>(b.between(0.65, 1));
  const Vec3f colour = clay ? b.tint({0.65f, 0.38f, 0.27f}) : b.any_colour(),
              dark = b.tint({0.22f, 0.16f, 0.11f}, 0.05);
  const auto outer = [=](float s) { return radius * (flare + (1 - flare) * s); };
  const int pot = b.new_part(), ground = b.new_part();
  const float floor = thick / height;
  b.add(
      Lathe(Vec3f::Zero(), Vec3f::UnitZ(), height, outer, [=](float s) { return s < floor ? 0.0f : outer(s) - thick; }),
      pot, colour, wall);
  // From outside one sees earth only at its top.
  const float top = 0.85f * height;
  b.add(
      Lathe(Vec3f(0, 0, thick), Vec3f::UnitZ(), top - thick,
            [=](float s) { return outer((thick + s * (top - thick)) / height) - thick; }),
      ground, [=](const ShapePoint& p) { return (1 - p.along) * top < p.depth || p.along > 0.85f ? dark : colour; },
      [earth](const ShapePoint&) { return earth; });
  return top;
}

PlantTissue herb(ObjectBuilder& b) {
  PlantTissue t;
  t.base = b.log_between(2e7, 2e9);
  t.tip_share = b.log_between(0.1, 0.7);
  t.rim = b.log_between(1, 3);
  t.leaf = b.log_between(3e6, 6e7);
  t.vein = b.log_between(2, 12);
  t.petal = b.log_between(2e5, 5e6);
  t.head = b.log_between(1e6, 3e7);
  t.moist = b.between(800, 1050);
  t.green = b.tint({0.28f, 0.48f, 0.18f}, 0.07);
  t.bark = b.tint({0.38f, 0.52f, 0.25f}, 0.07);
  return t;
}

PlantTissue woody(ObjectBuilder& b) {
  PlantTissue t = herb(b);
  t.base = b.log_between(2e9, 1.2e10);  // green wood
  t.tip_share = b.log_between(0.05, 0.5);
  t.moist = b.between(600, 1050);
  t.bark = b.tint({0.36f, 0.27f, 0.19f}, 0.06);
  return t;
}

void add_stem(ObjectBuilder& b, const PlantTissue& t, int part, const std::vector<Vec3f>& chain, float first,
              float last, double start, double end) {
  // Older tissue toward the foot is lignified, and supporting tissue lies at the rim.
  b.add(
      Tube(chain, first, last), part, [t](const ShapePoint&) { return t.bark; },
      [t, start, end](const ShapePoint& p) {
        const double way = start + (end - start) * p.along;
        return Substance{t.base * std::pow(t.tip_share, way) * std::pow(t.rim, p.across - 1), 0.35, t.moist};
      });
}

void add_leaf(ObjectBuilder& b, const PlantTissue& t, int part, const Vec3f& root, const Vec3f& direction, float length,
              float width, float thickness) {
  const float droop = static_cast<float>(b.between(0.1, 1.3)), sharp = static_cast<float>(b.between(0.6, 1.6));
  const float curl = static_cast<float>(b.between(-0.4, 0.4));
  const Vec3f side = direction.cross(Vec3f::UnitZ()).norm() > 0.1f ? Vec3f(direction.cross(Vec3f::UnitZ()))
                                                                   : across_axis(direction, 0.3f);
  const auto half = [=](float s) {
    return 0.5f * width * std::pow(std::sin(3.14159265f * std::clamp(s, 0.02f, 0.98f)), sharp);
  };
  const Vec3f colour = b.tint(t.green, 0.04), vein = b.tint(colour * 1.25f, 0.03);
  b.add(
      Sheet(curve(root, direction, length, -Vec3f::UnitZ(), droop), side, half, curl, thickness), part,
      [=](const ShapePoint& p) { return std::abs(p.across) < 0.12f ? vein : colour; },
      [t](const ShapePoint& p) {
        // The midrib carries the blade and thins out toward the tip.
        const double rib = std::abs(p.across) < 0.12f ? 1 + (t.vein - 1) * (1 - 0.7 * p.along) : 1;
        return Substance{t.leaf * rib * std::pow(0.6, p.along), 0.33, 800};
      });
}

void add_blossom(ObjectBuilder& b, const PlantTissue& t, int petal_part, int head_part, const Vec3f& centre,
                 const Vec3f& axis, float radius, int petals, const Vec3f& colour) {
  const float disc = radius * static_cast<float>(b.between(0.12, 0.4)), cup = static_cast<float>(b.between(-0.3, 1.1));
  const float turn = static_cast<float>(b.between(0, 6.28)),
              thick = radius * static_cast<float>(b.between(0.008, 0.03));
  const Vec3f heart = b.tint({0.75f, 0.6f, 0.15f}, 0.12);
  for (int k = 0; k < petals; ++k) {
    const Vec3f out = across_axis(axis, turn + 6.2831853f * static_cast<float>(k) / static_cast<float>(petals));
    const Vec3f direction = std::cos(cup) * out + std::sin(cup) * axis;
    const float width = std::min(1.2f, 7.0f / static_cast<float>(petals)) * radius * 0.7f;
    b.add(
        Sheet(
            curve(centre + 0.7f * disc * out, direction, radius - disc, axis, 0.4f), axis.cross(out),
            [=](float s) { return 0.5f * width * std::sin(0.3f + 2.6f * s); }, 0.2f, thick),
        petal_part, [colour](const ShapePoint&) { return colour; },
        // Younger, thinner tissue toward the edge.
        [t](const ShapePoint& p) {
          return Substance{t.petal * std::pow(0.5, p.along), 0.35, 750};
        });
  }
  b.add(Ellipsoid(centre, Vec3f(disc, disc, 0.5f * disc), axes_along(axis)), head_part, heart,
        Substance{t.head, 0.35, 850});
}

}  // namespace pliant
