#pragma once

// Parasol: cloth over ribs and struts on a pole; a hook to hold it by, a block of concrete or the bare tip below.

#include "tests/studies/held_out_assembly.h"

namespace pliant::study {

enum ParasolPart { kPole, kRibs, kCanopy, kFoot };

struct ParasolFrame {
  Material pole, rib;
  Vec3d pole_colour, rib_colour;
  double rib_radius;  // relative
};

/// A tube that is taken for a solid of the same outline: as stiff in bending, as heavy.
inline Material tube(double young, double poisson, double density, double wall_in_radii) {
  const double inner = 1 - wall_in_radii;
  return {young * (1 - std::pow(inner, 4)), poisson, density * (1 - inner * inner)};
}

inline ParasolFrame parasol_frame(Random& r, bool held) {
  const double kind = r.uniform(), wall = r.uniform(0.05, 0.12);
  const Vec3d wood = tint(r, blend({0.72, 0.53, 0.33}, {0.42, 0.26, 0.14}, r.uniform()), 0.06);
  // Hardwoods along the grain have 7.3 to 20.6 GPa, bamboo 19 GPa (handbook cards); fork joints and knots take some.
  if (kind < 0.45) {
    const double age = factor(r, 0.06);
    return {{age * r.uniform(8e9, 14e9), 0.37, r.uniform(550, 750)},
            held ? Material{age * r.uniform(12e9, 19e9), 0.35, r.uniform(650, 850)}
                 : Material{age * r.uniform(7e9, 13e9), 0.37, r.uniform(500, 720)},
            wood,
            tint(r, wood, 0.08),
            1.3};
  }
  const Vec3d paint = r.uniform() < 0.5 ? Vec3d(0.85, 0.85, 0.83) : Vec3d(0.22, 0.23, 0.24);
  // Steel 205 GPa; ribs are channels or flat tubes, filled to a third or a half (estimate).
  if (kind < 0.75)
    return {tube(205e9, 0.3, 7850, wall),
            {r.uniform(65e9, 105e9), 0.3, r.uniform(2600, 3900)},
            paint,
            r.uniform() < 0.5 ? paint : Vec3d(0.55, 0.56, 0.58),
            0.8};
  // Aluminium 69 GPa; rods of glass fibre in polyester 25 to 42 GPa along the fibres (estimate from the rule of
  // mixtures).
  return {tube(69e9, 0.33, 2700, 1.5 * wall),
          {r.uniform(25e9, 42e9), 0.28, r.uniform(1800, 2050)},
          Vec3d(0.66, 0.67, 0.69),
          Vec3d(0.15, 0.15, 0.16),
          0.9};
}

inline MaterialObject make_parasol(uint64_t seed) {
  Assembly a("parasol", seed);
  Random& r = a.random;
  const bool held = r.uniform() < 0.4;
  const ParasolFrame frame = parasol_frame(r, held);
  const double radius = held ? r.uniform(0.42, 0.6) : r.uniform(0.85, 1.5);
  const double tall = held ? r.uniform(0.75, 0.92) : r.uniform(1.9, 2.45);
  const double pole = held ? r.uniform(0.005, 0.008) : r.uniform(0.017, 0.025);
  const int panels = held ? 8 : 6 + 2 * static_cast<int>(r.below(2));
  const double depth = radius * r.uniform(0.25, 0.5), bow = held ? r.uniform(1.6, 2.3) : r.uniform(1.05, 1.5);
  const double sag = r.uniform(0.02, 0.06), billow = r.uniform(0.01, 0.035) * radius, turn = r.uniform(0, 2 * M_PI);

  // The top leans; the lower part of a garden parasol stands upright below the joint.
  const double lean = held ? r.uniform(0, 0.6) : (r.uniform() < 0.4 ? r.uniform(0.15, 0.45) : 0.04 * r.uniform());
  const double azimuth = r.uniform(0, 2 * M_PI);
  const Vec3d axis(std::sin(lean) * std::cos(azimuth), std::sin(lean) * std::sin(azimuth), std::cos(lean));
  const double joint = held ? 0 : tall - depth - 0.25 * radius;
  const Frame top = frame_along(joint * Vec3d::UnitZ(), axis, Vec3d::UnitX());  // its z starts at the joint
  const double apex = tall - joint;

  const auto even = [](const Look& look) { return [look](double, double) { return look; }; };
  const auto constant = [](double value) { return [value](double) { return value; }; };
  const Look of_pole{frame.pole_colour, frame.pole};
  if (!held) a.add_rod(kPole, straight(Vec3d::Zero(), top.origin), constant(pole), even(of_pole));
  a.add_rod(kPole, straight(top.origin, top.at({0, 0, apex})), constant(pole), even(of_pole));
  // Crown and runner are of nylon (2.9 GPa); the tip is as the pole.
  const Look nylon{tint(r, {0.13, 0.13, 0.13}, 0.1), {r.uniform(1.5e9, 2.9e9), 0.39, 1140}};
  const double runner = apex - depth * 0.55 - 0.16 * radius, reach = r.uniform(0.42, 0.6);
  a.add_rod(kPole, straight(top.at({0, 0, apex - 2 * pole}), top.at({0, 0, apex + pole})), constant(2 * pole),
            even(nylon));
  a.add_rod(kPole, straight(top.at({0, 0, runner - 2 * pole}), top.at({0, 0, runner + 2 * pole})), constant(1.9 * pole),
            even(nylon));
  a.add_rod(kPole, straight(top.at({0, 0, apex + pole}), top.at({0, 0, apex + (held ? 0.05 : 0.09)})),
            constant(0.8 * pole), even(of_pole));

  const auto canopy = [=](int k, double u, double v) -> Vec3d {
    const double sector = 2 * M_PI / panels, from_middle = (v - 0.5) * sector, hump = 1 - std::pow(2 * v - 1, 2);
    const double chord = std::cos(sector / 2) / std::cos(from_middle) * (1 - sag * u * hump), q = 0.02 + 0.98 * u;
    const double angle = turn + (k + v) * sector;
    return top.at({radius * q * chord * std::cos(angle), radius * q * chord * std::sin(angle),
                   apex - depth * std::pow(q, bow) - billow * q * hump});
  };
  const double rib = frame.rib_radius * (held ? 0.0022 : r.uniform(0.005, 0.007));
  for (int k = 0; k < panels; ++k) {
    const Look look{frame.rib_colour, scaled(frame.rib, factor(r, 0.04))};
    Curve curve;
    for (int i = 0; i <= 24; ++i) curve.points.push_back(canopy(k, i / 24.0, 0) - (rib + 0.001) * axis);
    a.add_rod(
        kRibs, curve, [=](double s) { return rib * (1 - 0.25 * s); }, even(look));
    a.add_rod(kRibs, straight(top.at({0, 0, runner}), curve.at(reach)), constant(0.9 * rib), even(look));
  }

  // Woven polyester and cotton start at 0.5 and 0.8 MPa while the weave straightens (Penava et al. 2014, as in C-IPC);
  // taut and coated they pull like some 100 MPa (estimate).  A canopy that flutters lies between; seams and the hem are
  // two or three layers with stitches.
  const double age = factor(r, 0.08), cloth = held ? r.uniform(1.2e-4, 2.5e-4) : r.uniform(2.5e-4, 6e-4);
  const Material fabric{age * log_uniform(r, 2e6, 50e6), r.uniform(0.2, 0.38), r.uniform(450, 700)};
  Vec3d dye[2] = {{r.uniform(0.1, 0.95), r.uniform(0.1, 0.9), r.uniform(0.1, 0.9)}, {0.92, 0.90, 0.84}};
  if (r.uniform() < 0.55) dye[1] = dye[0];
  const double hem = held ? 0.01 : 0.02, valance = !held && r.uniform() < 0.45 ? r.uniform(0.1, 0.2) : 0;
  for (int k = 0; k < panels; ++k) {
    const Vec3d colour = tint(r, dye[k % 2], 0.03);
    const Material own = scaled(fabric, factor(r, 0.04));
    const auto doubled = [=](double u, double v) {
      const double across = 2 * M_PI / panels * radius * u * std::min(v, 1 - v);
      return across < hem || (1 - u) * radius < hem;
    };
    a.add_sheet(
        kCanopy, [=](double u, double v) { return canopy(k, u, v); },
        [=](double u, double v) { return doubled(u, v) ? 2 * cloth : cloth; },
        [=](double u, double v) {
          return Look{colour * (doubled(u, v) ? 0.92 : 1.0), scaled(own, doubled(u, v) ? 1.8 : 1.0)};
        });
    if (valance > 0)
      a.add_sheet(
          kCanopy,
          [=](double u, double v) -> Vec3d {
            return canopy(k, 1, v) - valance * u * (0.8 + 0.2 * std::sin(M_PI * v)) * axis;
          },
          [=](double, double) { return cloth; }, even({colour, own}));
  }

  if (held) {
    // The grip ends in a hook of wood or of ABS (2.3 GPa).
    const bool wood = r.uniform() < 0.6;
    const Look grip = wood ? Look{tint(r, {0.45, 0.28, 0.15}, 0.1), {r.uniform(8e9, 13e9), 0.37, r.uniform(600, 750)}}
                           : Look{tint(r, {0.16, 0.15, 0.15}, 0.1), {r.uniform(1.9e9, 2.5e9), 0.38, 1050}};
    const double hook = r.uniform(0.028, 0.04), grip_length = r.uniform(0.07, 0.12);
    Curve curve;
    for (double z = grip_length; z > 0; z -= 0.006) curve.points.push_back(top.at({0, 0, z - grip_length}));
    for (double angle = 0; angle < 3.3; angle += 0.006 / hook)
      curve.points.push_back(top.at({hook * (1 - std::cos(angle)), 0, -grip_length - hook * std::sin(angle)}));
    const double thick = r.uniform(0.009, 0.012);
    a.add_rod(kFoot, curve, constant(thick), even(grip));
  } else if (r.uniform() < 0.6) {
    // Concrete: 20 to 33 GPa by its grade.
    const double wide = r.uniform(0.19, 0.27), high = r.uniform(0.05, 0.09);
    const Look block{tint(r, {0.58, 0.57, 0.55}, 0.04), {r.uniform(20e9, 33e9), 0.2, r.uniform(2200, 2400)}};
    a.add_solid(
        kFoot, frame_along(Vec3d::Zero(), Vec3d::UnitZ(), Vec3d::UnitX()), Vec3d(-wide, -wide, 0),
        Vec3d(wide, wide, high),
        [=](const Vec3d& p) {
          const double q = std::hypot(p.x(), p.y());
          return q < wide - 0.25 * p.z() && q > pole;
        },
        [=](const Vec3d&) { return block; });
  }
  return a.finish(1400 + static_cast<int>(r.below(900)));
}

}  // namespace pliant::study
