#pragma once

// Sunflower: a tapered stalk of rind and pith that nods under a heavy head, ray petals, heart-shaped leaves.

#include "tests/studies/held_out_assembly.h"

namespace pliant::study {

enum SunflowerPart { kStalk, kHead, kPetals, kLeaves };

/// Moduli of one plant.  Dryness 0 is turgid, 1 is straw.
struct SunflowerTissue {
  double dryness;
  Material rind, pith, receptacle, seeds, bract, petal, lamina, vein, petiole;
};

inline SunflowerTissue sunflower_tissue(Random& r) {
  SunflowerTissue t;
  const double d = t.dryness = 0.8 * std::pow(r.uniform(), 1.5);
  const double plant = factor(r, 0.12);
  const auto pa = [&](double low, double high, double decades) {
    return plant * log_uniform(r, low, high) * std::pow(10, decades * d);
  };
  // Dry maize rind has 6 to 16 GPa (Al-Zube et al. 2018).  That of maize (Plant Methods 2023, 01039) and sunflower
  // (Sun et al. 2014) falls with water.  Fresh: a third to a tenth of it.
  t.rind = {pa(0.7e9, 2.5e9, 0.6), 0.3, 1000 - 450 * d};
  // Maize pith is a median of 17 times softer than its rind, stiffest when turgid (Plant Methods 2023, 01039); that of
  // sunflower is a foam of thin-walled parenchyma, whose moduli begin at 0.3 MPa (Gibson 2012).  Between: 5 to 30 MPa.
  t.pith = {pa(5e6, 30e6, -0.4), 0.42 - 0.2 * d, 700 - 600 * d};
  // The receptacle is spongy parenchyma with bundles (estimate); hulls are woody but lie loosely side by side
  // (estimate: a twentieth of dry rind); bracts are thick leaves.
  t.receptacle = {pa(2e6, 9e6, 0.2), 0.4, 800 - 450 * d};
  t.seeds = {pa(20e6, 90e6, 0.6), 0.3, 850 - 250 * d};
  t.bract = {pa(12e6, 50e6, 0.5), 0.35, 900 - 400 * d};
  // Petals have neither fibres nor a thick cuticle (estimate: the low end of turgid tissue).
  t.petal = {pa(1e6, 6e6, 0.5), 0.4, 900 - 400 * d};
  // Bulk moduli of leaves of oak are 5 to 20 MPa and go with Young's (Saito et al. 2006); a vein of butterbur has
  // 60 MPa (J. Soc. Mat. Sci. Japan 49, 1318); petioles of herbs bend like 0.1 to 0.5 GPa (estimate).
  t.lamina = {pa(6e6, 30e6, 0.5), 0.35, 850 - 400 * d};
  t.vein = {pa(40e6, 150e6, 0.5), 0.33, 950 - 400 * d};
  t.petiole = {pa(100e6, 400e6, 0.5), 0.33, 950 - 400 * d};
  return t;
}

inline void add_leaf(Assembly& a, const SunflowerTissue& t, const Vec3d& base, double azimuth, double length) {
  Random& r = a.random;
  const double leaf = factor(r, 0.08), petiole = length * r.uniform(0.35, 0.6), width = length * r.uniform(0.36, 0.46);
  const double rise = r.uniform(0.4, 0.9) - 0.5 * t.dryness, droop = r.uniform(0.8, 1.6) + 1.2 * t.dryness;
  const double fold = r.uniform(0.1, 0.35), wave = r.uniform(0.01, 0.03) * length, phase = r.uniform(0, 6.28);
  const Vec3d out(std::cos(azimuth), std::sin(azimuth), 0), side(-out.y(), out.x(), 0), up = Vec3d::UnitZ();
  const auto heading = [=](double angle) -> Vec3d { return std::cos(angle) * out + std::sin(angle) * up; };

  // The petiole goes on as the midrib, which bends down.
  constexpr int kSteps = 40;
  Curve stem{{base}}, midrib;
  for (int i = 0; i < kSteps; ++i)
    stem.points.push_back(stem.points.back() + petiole / kSteps * heading(rise - 0.3 * i / kSteps));
  midrib.points = {stem.points.back()};
  const auto pitch = [=](double u) { return rise - 0.3 - droop * u; };
  for (int i = 0; i < kSteps; ++i)
    midrib.points.push_back(midrib.points.back() + length / kSteps * heading(pitch((i + 0.5) / kSteps)));

  const Vec3d green = tint(r, blend({0.24, 0.43, 0.13}, {0.47, 0.40, 0.18}, t.dryness), 0.05);
  const Vec3d pale = blend(green, {0.72, 0.78, 0.46}, 0.5);
  const double thick = 0.0135 * length;  // of the petiole
  const auto taper = [=](double u) { return 0.5 * thick * (0.75 - 0.65 * u); };
  a.add_rod(
      kLeaves, stem, [=](double s) { return 0.5 * thick * (1 - 0.25 * s); },
      [=](double s, double) {
        return Look{pale, scaled(t.petiole, leaf * (1.3 - 0.5 * s))};
      },
      1);
  a.add_rod(
      kLeaves, midrib, taper,
      [=](double s, double) {
        return Look{pale,
                    {leaf * blend_log(t.petiole.young, t.vein.young, std::min(1.0, 0.3 + s)), 0.33, t.vein.density}};
      },
      1);

  // Half width over the midrib; lobes reach behind the petiole.
  const auto surface = [=](double u, double w) -> Vec3d {
    const double half = width * std::pow(std::max(0.0, std::sin(M_PI * std::pow(u, 0.55))), 0.85);
    const double along = u - 0.22 * w * w * std::pow(1 - u, 3);
    const Vec3d normal = heading(pitch(u) + M_PI / 2);
    const Vec3d spine = along < 0 ? Vec3d(midrib.at(0) + along * length * heading(pitch(0))) : midrib.at(along);
    return spine + half * w * side +
           (fold * half * std::abs(w) + wave * w * w * std::sin(9 * u + phase + (w > 0 ? 1.3 : 0))) * normal;
  };
  const double sheet = r.uniform(2.5e-4, 4.5e-4);
  a.add_sheet(
      kLeaves, [=](double u, double v) { return surface(u, 2 * v - 1); }, [=](double, double) { return sheet; },
      [=](double u, double v) {
        const double edge = std::abs(2 * v - 1);
        const Vec3d dry = blend(green, {0.52, 0.44, 0.22}, 0.7 * t.dryness * smooth_step(0.6, 1, edge));
        return Look{dry, scaled(t.lamina, leaf * (1.3 - 0.5 * std::max(edge, u)))};
      });

  // Pairs of side veins run outwards and forwards.
  for (const double from : {0.03, 0.2, 0.38, 0.56})
    for (const int s : {-1, 1}) {
      Curve vein;
      for (int i = 0; i <= 12; ++i) vein.points.push_back(surface(from + 0.025 + 0.2 * i / 12, s * 0.85 * i / 12));
      a.add_rod(
          kLeaves, vein, [=](double q) { return 0.45 * taper(from) * (1 - 0.7 * q); },
          [=](double q, double) {
            return Look{blend(pale, green, 0.5 * q), scaled(t.vein, leaf * (1 - 0.4 * q))};
          },
          1);
    }
}

inline void add_head(Assembly& a, const SunflowerTissue& t, const Frame& frame, double radius) {
  Random& r = a.random;
  // The frame's z looks out of the face.  Front and back of the disc over the distance from its axis:
  const double depth = r.uniform(0.3, 0.5) * radius, dome = r.uniform(-0.05, 0.2) * radius, ripe = r.uniform(0.2, 0.75);
  const auto front = [=](double q) { return 0.3 * depth + dome * (1 - q * q); };
  const auto back = [=](double q) { return -0.7 * depth * std::sqrt(std::max(0.0, 1 - q * q)); };
  const Vec3d heart = tint(r, {0.27, 0.19, 0.07}, 0.15), ring = tint(r, {0.50, 0.31, 0.07}, 0.12);
  const Vec3d green = tint(r, blend({0.40, 0.52, 0.20}, {0.60, 0.52, 0.30}, t.dryness), 0.06);
  const double layer = r.uniform(0.010, 0.015);  // length of a seed
  a.add_solid(
      kHead, frame, Vec3d(-radius, -radius, -depth), Vec3d(radius, radius, depth + 0.2 * radius),
      [=](const Vec3d& p) {
        const double q = std::hypot(p.x(), p.y()) / radius;
        return q < 1 && p.z() < front(q) && p.z() > back(q);
      },
      [=](const Vec3d& p) {
        const double q = std::hypot(p.x(), p.y()) / radius;
        const double below = front(q) - p.z(), above = p.z() - back(q);
        const double spiral = 0.5 + 0.5 * std::sin(13 * std::atan2(p.y(), p.x()) + 40 * std::sqrt(q));
        const Vec3d face = blend(heart, ring, smooth_step(ripe - 0.2, ripe + 0.1, q)) * (0.75 + 0.4 * spiral);
        // Seeds ripen from the rim inwards; the green back is a skin of bract tissue.
        Material m = t.receptacle;
        if (below < layer) {
          m = t.seeds;
          m.young = blend_log(0.25 * m.young, m.young, smooth_step(0.1, 0.8, q));
        } else if (above < 0.003) {
          m = t.bract;
        }
        return Look{below < above ? face : green, m};
      });

  const bool red = r.uniform() < 0.15;
  const Vec3d tip = tint(r, red ? Vec3d(0.72, 0.28, 0.08) : Vec3d(0.96, 0.76, 0.09), 0.06);
  const Vec3d root = red ? Vec3d(0.45, 0.10, 0.06) : Vec3d(0.92, 0.56, 0.04);
  // Pointed sheets around the rim: petals in two rings, bracts behind them.
  struct Blade {
    double angle, length, width, z, lift, curl, thickness;
  };
  const auto add_blade = [&](int part, const Blade& b, const std::function<Look(double)>& look) {
    const Vec3d out = std::cos(b.angle) * frame.x + std::sin(b.angle) * frame.y, side = frame.z.cross(out);
    const Vec3d root_at = frame.origin + 0.96 * radius * out + b.z * frame.z, sag = 0.15 * t.dryness * Vec3d::UnitZ();
    const auto surface = [=](double u, double v) -> Vec3d {
      const double w = 2 * v - 1, bend = b.lift - b.curl * u;  // an arc, to second order
      const double half = 0.5 * b.width * std::pow(std::max(0.0, std::sin(M_PI * (0.08 + 0.92 * u))), 0.7);
      return root_at + b.length * u * (std::cos(bend) * out + std::sin(bend) * frame.z) + half * w * side +
             0.2 * half * w * w * frame.z - b.length * u * u * sag;
    };
    a.add_sheet(
        part, surface, [=](double, double) { return b.thickness; }, [=](double u, double) { return look(u); });
  };
  const int petals = 24 + static_cast<int>(r.below(20));
  const double longest = r.uniform(0.6, 0.95) * radius, lift = r.uniform(-0.1, 0.45);
  for (int i = 0; i < petals; ++i) {
    const double own = factor(r, 0.08);
    const Vec3d colour = tint(r, tip, 0.05);
    const Blade petal{.angle = 2 * M_PI * (i + r.uniform(-0.2, 0.2)) / petals,
                      .length = longest * r.uniform(0.85, 1.15),
                      .width = 0.3 * longest * r.uniform(0.8, 1.2),
                      .z = (i % 2 ? 0.05 : 0.18) * depth,
                      .lift = lift + 0.12 * r.normal(),
                      .curl = r.uniform(0, 0.5),
                      .thickness = r.uniform(2.5e-4, 4e-4)};
    add_blade(kPetals, petal, [=](double u) {
      return Look{blend(root, colour, smooth_step(0, 0.4, u)), scaled(t.petal, own * (1.6 - 0.9 * u))};
    });
  }
  const int bracts = 14 + static_cast<int>(r.below(10));
  for (int i = 0; i < bracts; ++i) {
    const double own = factor(r, 0.08);
    const Blade bract{.angle = 2 * M_PI * (i + 0.5 + r.uniform(-0.2, 0.2)) / bracts,
                      .length = 0.4 * radius * r.uniform(0.8, 1.2),
                      .width = 0.22 * radius,
                      .z = -0.15 * depth,
                      .lift = r.uniform(-0.5, 0.1),
                      .curl = r.uniform(0, 0.6),
                      .thickness = r.uniform(7e-4, 1.2e-3)};
    add_blade(kHead, bract, [=](double u) { return Look{green, scaled(t.bract, own * (1.2 - 0.5 * u))}; });
  }
}

inline MaterialObject make_sunflower(uint64_t seed) {
  Assembly a("sunflower", seed);
  Random& r = a.random;
  const SunflowerTissue t = sunflower_tissue(r);
  const double height = r.uniform(0.7, 2.1), thick = height * r.uniform(0.0065, 0.0095);  // radius at the ground
  const double head = std::min(0.15, height * r.uniform(0.06, 0.095));

  // The direction of the stalk leans steadily and turns over at the neck.
  const double azimuth = r.uniform(0, 2 * M_PI), lean = r.uniform(-0.15, 0.3), nod = r.uniform(0.6, 1.7);
  const Vec3d towards(std::cos(azimuth), std::sin(azimuth), 0), side(-towards.y(), towards.x(), 0);
  const double sway = r.uniform(-0.08, 0.08);
  constexpr int kSteps = 120;
  Curve stalk{{Vec3d::Zero()}};
  for (int i = 0; i < kSteps; ++i) {
    const double s = (i + 0.5) / kSteps, angle = lean * s + nod * smooth_step(0.84, 1, s);
    stalk.points.push_back(stalk.points.back() + height / kSteps *
                                                     (std::cos(angle) * Vec3d::UnitZ() + std::sin(angle) * towards +
                                                      sway * std::sin(5 * s) * side)
                                                         .normalized());
  }

  // The rind makes up a tenth to a sixth of the radius; it is stiffer towards the top (Sun et al. 2013, 2014) but green
  // at the neck, where it lets the head nod.
  const double rind = r.uniform(0.1, 0.17);
  const Vec3d green = tint(r, blend({0.43, 0.55, 0.23}, {0.67, 0.58, 0.36}, t.dryness), 0.06);
  a.add_rod(
      kStalk, stalk, [=](double s) { return thick * (1 - 0.45 * s); },
      [=](double s, double rho) {
        const double up = (0.8 + 0.5 * s) * std::pow(10, -0.5 * smooth_step(0.84, 0.97, s));
        const Vec3d colour = blend(blend(green, {0.55, 0.48, 0.30}, 0.6), green, smooth_step(0, 0.2, s));
        return Look{colour, rho > 1 - rind ? scaled(t.rind, up) : scaled(t.pith, 0.9 + 0.2 * s)};
      });

  const Vec3d end = stalk.at(1), face = stalk.direction(1);
  add_head(a, t, frame_along(end + 0.25 * head * face, face, side), head);
  const int leaves = 6 + static_cast<int>(r.below(7));
  const double first = r.uniform(0, 2 * M_PI), longest = std::min(0.3, height * r.uniform(0.13, 0.18));
  for (int i = 0; i < leaves; ++i) {
    const double s = 0.15 + 0.68 * (i + r.uniform(-0.2, 0.2)) / (leaves - 1);
    const double size = longest * (0.55 + 0.45 * std::sin(M_PI * std::clamp(1.1 * s, 0.0, 1.0))) * r.uniform(0.85, 1.1);
    add_leaf(a, t, stalk.at(s), first + 2.39996 * i + 0.2 * r.normal(), size);  // the golden angle
  }
  return a.finish(1500 + static_cast<int>(r.below(800)));
}

}  // namespace pliant::study
