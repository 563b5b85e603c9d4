#include "app/demo/flower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFrequency = 2.2;                            // Hz
constexpr double kPoisson = 0.28, kDensity = 700;             // -, kg/m^3
constexpr double kLeafSoftness = 8.2, kBlossomSoftness = 16;  // Young's modulus of the stem over that of the part

Isometry3d frame(const Vec3d& origin, const Vec3d& x, const Vec3d& y) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear().col(0) = x;
  pose.linear().col(1) = y;
  pose.linear().col(2) = x.cross(y);
  pose.translation() = origin;
  return pose;
}

constexpr double kPotWall = 0.006;  // m

/// Outer wall, lip and inner wall down to the soil.
std::vector<Vector2d> pot_profile(double radius, double height, double soil) {
  const double foot = 0.74 * radius, lip = 0.018;
  return {{foot, 0},
          {radius - 0.005, height - lip},
          {radius, height - lip + 0.002},
          {radius, height - 0.003},
          {radius - 0.003, height},
          {radius - kPotWall + 0.002, height},
          {radius - kPotWall, height - 0.002},
          {radius - kPotWall, soil}};
}

/// Soil that rises a little towards the stem.
std::vector<Vector2d> soil_profile(double radius, double soil, double stem_radius) {
  const double outer = radius - kPotWall;
  return {{outer, soil}, {0.5 * (outer + stem_radius), soil + 0.004}, {stem_radius - 0.002, soil + 0.006}};
}

/// Tapered stem that ends in a low dome.
std::vector<Vector2d> stem_profile(double bottom, double bottom_radius, double top, double tip_radius) {
  std::vector<Vector2d> profile = {{bottom_radius, bottom}, {tip_radius, top}};
  const int pieces = 6;
  for (int i = 1; i <= pieces; ++i) {
    const double angle = 90 * kDegree * i / pieces;
    profile.emplace_back(i == pieces ? 0 : tip_radius * std::cos(angle), top + 0.5 * tip_radius * std::sin(angle));
  }
  return profile;
}

/// A rigid body on the stem: it moves with the stem at `attached`, turning with its slope.
struct Rider {
  double attached, centre, mass;  ///< heights above the pinned plane [m], [kg]
};

/// Riders and geometry of the stem seen as a tapered beam, clamped at the pinned plane.
struct Beam {
  double length, base_radius, tip_radius;
  std::vector<Rider> riders;
  double radius(double z) const { return base_radius + (tip_radius - base_radius) * z / length; }
};

struct BeamShape {
  std::vector<double> deflection, slope;  ///< at the nodes
};

constexpr int kBeamSegments = 400;

/// Static shape under horizontal forces: line load q [N/m] on the stem and `force` on each rider; Timoshenko beam with
/// shear coefficient 0.9.
BeamShape bend(const Beam& beam, const ElasticSolid& solid, double density_load, const std::vector<double>& force) {
  const double h = beam.length / kBeamSegments, shear_modulus = solid.young / (2 * (1 + solid.poisson));
  std::vector<double> shear(kBeamSegments), moment(kBeamSegments);
  double line = 0, line_moment = 0;  // of the stem above
  for (int i = kBeamSegments - 1; i >= 0; --i) {
    const double z = (i + 0.5) * h, area = std::numbers::pi * beam.radius(z) * beam.radius(z), q = density_load * area;
    shear[i] = line + 0.5 * q * h;
    moment[i] = line_moment + 0.5 * h * line;
    line_moment += h * line + 0.5 * q * h * h;
    line += q * h;
    for (size_t r = 0; r < beam.riders.size(); ++r)
      if (beam.riders[r].attached > z) {
        shear[i] += force[r];
        moment[i] += force[r] * (beam.riders[r].centre - z);
      }
  }
  BeamShape shape{std::vector<double>(kBeamSegments + 1, 0), std::vector<double>(kBeamSegments + 1, 0)};
  double rotation = 0;
  for (int i = 0; i < kBeamSegments; ++i) {
    const double r = beam.radius((i + 0.5) * h), area = std::numbers::pi * r * r, second = area * r * r / 4;
    const double curvature = moment[i] / (solid.young * second);
    shape.deflection[i + 1] =
        shape.deflection[i] + h * (rotation + 0.5 * h * curvature + shear[i] / (0.9 * shear_modulus * area));
    rotation += h * curvature;
    shape.slope[i + 1] = rotation;
  }
  return shape;
}

double rider_deflection(const Beam& beam, const BeamShape& shape, const Rider& rider) {
  const int node =
      std::clamp(static_cast<int>(std::lround(rider.attached / beam.length * kBeamSegments)), 0, kBeamSegments);
  return shape.deflection[node] + shape.slope[node] * (rider.centre - rider.attached);
}

/// Rayleigh's quotient with the shape under a uniform horizontal acceleration: omega^2 = sum m a w / sum m w^2.
double first_frequency(const Beam& beam, const ElasticSolid& solid) {
  std::vector<double> force;
  for (const Rider& rider : beam.riders) force.push_back(rider.mass);
  const BeamShape shape = bend(beam, solid, solid.density, force);
  double work = 0, energy = 0;
  for (int i = 0; i < kBeamSegments; ++i) {
    const double h = beam.length / kBeamSegments, r = beam.radius((i + 0.5) * h);
    const double mass = solid.density * std::numbers::pi * r * r * h,
                 w = 0.5 * (shape.deflection[i] + shape.deflection[i + 1]);
    work += mass * w;
    energy += mass * w * w;
  }
  for (const Rider& rider : beam.riders) {
    const double w = rider_deflection(beam, shape, rider);
    work += rider.mass * w;
    energy += rider.mass * w * w;
  }
  return std::sqrt(work / energy) / (2 * std::numbers::pi);
}

/// The stem as a beam; leaves and blossom ride on it with the mass of their part outside the stem.
Beam beam_of(const Flower& flower, const FlowerSolid& samples) {
  Beam beam{flower.free_length, flower.base_diameter / 2, flower.tip_diameter / 2, {}};
  std::vector<Rider> riders(3);  // leaf on +x, leaf on -x, blossom with the dome of the stem
  for (size_t i = 0; i < samples.position.size(); ++i) {
    const Vec3d& x = samples.position[i];
    const double z = x.z() - flower.pin_height;
    if (samples.part[i] == FlowerPart::kStem && z <= flower.free_length) continue;
    Rider& rider = riders[samples.part[i] == FlowerPart::kLeaf ? (x.x() > 0 ? 0 : 1) : 2];
    const double mass = flower.solid(samples.part[i]).density * samples.cell * samples.cell * samples.cell;
    rider.centre += mass * z;
    rider.mass += mass;
  }
  for (size_t r = 0; r < riders.size(); ++r) {
    riders[r].centre /= riders[r].mass;
    // A leaf climbs outwards: its root lies below its centre of mass by the rise of half its length.
    riders[r].attached =
        r == 2 ? flower.free_length : std::max(0.0, riders[r].centre - 0.6 * flower.leaf_semi_axes.x());
  }
  beam.riders = riders;
  return beam;
}

}  // namespace

FlowerPart Flower::part_at(const Vec3d& x) const {
  for (const FlowerPiece& piece : pieces)
    if (piece.part != FlowerPart::kPot && piece.contains(x)) return piece.part;
  return FlowerPart::kNone;
}

Flower make_flower(uint64_t seed) {
  Random random(seed, 1);
  Flower f;
  const double d = f.tip_diameter = random.uniform(0.046, 0.050);
  f.base_diameter = d * random.uniform(1.43, 1.47);
  f.free_length = 3.5 * d;
  const double pot_height = random.uniform(0.080, 0.090);
  f.pot_radius = 1.5 * d;
  f.soil_height = pot_height - 0.010;
  f.pin_height = f.soil_height + 0.75 * d;

  const double taper = (f.base_diameter - d) / 2 / f.free_length;
  auto stem_radius = [&](double z) { return f.base_diameter / 2 - taper * (z - f.pin_height); };
  const double bottom = f.soil_height - 0.35 * d, top = f.pin_height + f.free_length;
  auto add = [&](FlowerPart part, std::unique_ptr<AnalyticShape> shape, const Isometry3d& pose, int tone) {
    const Vec3d centre = pose * shape->bound_centre();
    const double radius = shape->bound_radius();
    f.pieces.push_back({part, std::move(shape), pose, tone, centre, radius});
  };
  const Isometry3d upright = Isometry3d::Identity();
  add(FlowerPart::kPot, make_lathe(pot_profile(f.pot_radius, pot_height, f.soil_height)), upright, 0);
  add(FlowerPart::kPot, make_lathe(soil_profile(f.pot_radius, f.soil_height, stem_radius(f.soil_height))), upright, 1);
  add(FlowerPart::kStem, make_lathe(stem_profile(bottom, stem_radius(bottom), top, d / 2)), upright, 0);

  f.leaf_semi_axes = d * Vec3d(random.uniform(0.96, 1.04), 0.50, 0.31);
  for (int side = 0; side < 2; ++side) {
    const double azimuth = (180 * side + random.uniform(-20, 20)) * kDegree, rise = random.uniform(30, 40) * kDegree;
    const double height = f.pin_height + d * ((side ? 1.55 : 1.05) + random.uniform(-0.1, 0.1));
    const Vec3d out(std::cos(azimuth), std::sin(azimuth), 0),
        along = std::cos(rise) * out + std::sin(rise) * Vec3d::UnitZ();
    const Vec3d root(0, 0, height);
    const Vec3d centre = root + along * (0.55 * stem_radius(height) + f.leaf_semi_axes.x());
    add(FlowerPart::kLeaf, make_ellipsoid(f.leaf_semi_axes), frame(centre, along, Vec3d::UnitZ().cross(out)), side);
  }

  // Petals stand around the axis of the blossom, which looks to the front and up.
  const double tilt = random.uniform(28, 42) * kDegree, phase = random.uniform(0, 60) * kDegree;
  const Vec3d facing(0, -std::cos(tilt), std::sin(tilt)), side(1, 0, 0), rising = side.cross(-facing);
  f.blossom_centre = Vec3d(0, 0, top) + 0.42 * d * facing;
  add(FlowerPart::kBlossom, make_ellipsoid(d * Vec3d(0.30, 0.37, 0.37)),
      frame(f.blossom_centre + 0.10 * d * facing, facing, side), 0);
  for (int k = 0; k < 6; ++k) {
    const double angle = phase + 60 * kDegree * k;
    const Vec3d radial = std::cos(angle) * side + std::sin(angle) * rising;
    add(FlowerPart::kBlossom, make_ellipsoid(d * Vec3d(0.36, 0.29, 0.27)),
        frame(f.blossom_centre + 0.54 * d * radial, radial, facing.cross(radial)), 1 + k % 2);
  }

  for (const FlowerPiece& piece : f.pieces)
    for (const SurfacePoint& p : piece.shape->cover(0.05 * d, seed)) {
      const Vec3d x = piece.flower_from_local * p.position;
      f.height = std::max(f.height, x.z());
      f.reach = std::max(f.reach, x.head<2>().norm());
    }

  // The frequency goes with the square root of Young's modulus.
  f.stem = {1e5, kPoisson, kDensity};
  f.leaf = {1e5 / kLeafSoftness, kPoisson, kDensity};
  f.blossom = {1e5 / kBlossomSoftness, kPoisson, kDensity};
  const double scale = std::pow(kFrequency / flower_mechanics(f).frequency, 2);
  for (ElasticSolid* solid : {&f.stem, &f.leaf, &f.blossom}) solid->young *= scale;
  return f;
}

FlowerSolid sample_flower(const Flower& flower, double cell, double lowest, uint64_t seed) {
  const Eigen::Vector3i low(static_cast<int>(std::floor(-flower.reach / cell)),
                            static_cast<int>(std::floor(-flower.reach / cell)), 0);
  const int across = -2 * low.x(), layers = static_cast<int>(std::ceil((flower.height - lowest) / cell));
  std::vector<FlowerSolid> layer(std::max(0, layers));
  parallel_for(layers, [&](std::ptrdiff_t k) {
    for (int j = 0; j < across; ++j)
      for (int i = 0; i < across; ++i) {
        Random random(seed, static_cast<uint64_t>((k * across + j) * across + i));
        const Vec3d in_cell(random.uniform(), random.uniform(), random.uniform());
        const Vec3d x =
            Vec3d(0, 0, lowest) + cell * (Vec3d(low.x() + i, low.y() + j, static_cast<double>(k)) + in_cell);
        const FlowerPart part = flower.part_at(x);
        if (part == FlowerPart::kNone) continue;
        layer[k].position.push_back(x);
        layer[k].part.push_back(part);
      }
  });
  FlowerSolid samples;
  samples.cell = cell;
  for (const FlowerSolid& l : layer) {
    samples.position.insert(samples.position.end(), l.position.begin(), l.position.end());
    samples.part.insert(samples.part.end(), l.part.begin(), l.part.end());
  }
  return samples;
}

FlowerMechanics flower_mechanics(const Flower& flower) {
  FlowerMechanics m;
  const double d = flower.tip_diameter;
  const FlowerSolid above = sample_flower(flower, d / 20, flower.pin_height, 0);
  // The layer of three cells below the pinned plane belongs to the solid, so spacing and volume are found together.
  auto volume_with = [&](double cell) {
    const double r = flower.base_diameter / 2 + 1.5 * cell * (flower.base_diameter - d) / 2 / flower.free_length;
    return above.volume() + std::numbers::pi * r * r * 3 * cell;
  };
  auto cell_for = [&](double particles) {
    double cell = std::cbrt(8 * above.volume() / particles);
    for (int i = 0; i < 40; ++i) cell = std::cbrt(8 * volume_with(cell) / particles);
    return cell;
  };
  m.cell_8k = cell_for(8000);
  m.cell_4k = cell_for(4000);
  m.volume = volume_with(m.cell_8k);
  m.stem_cells = d / m.cell_8k;
  m.leaf_cells = 2 * flower.leaf_semi_axes.z() / m.cell_8k;
  m.contrast = flower.stem.young / std::max(flower.leaf.young, flower.blossom.young);

  const Beam beam = beam_of(flower, above);
  m.frequency = first_frequency(beam, flower.stem);
  const BeamShape pushed = bend(beam, flower.stem, 0, {0, 0, 1});
  m.compliance = rider_deflection(beam, pushed, beam.riders[2]);

  const double nu = flower.stem.poisson;
  const double modulus = flower.stem.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));  // lambda + 2 mu
  m.substeps_4k = std::sqrt(modulus / flower.stem.density) / (0.4 * m.cell_4k * 30);
  return m;
}

}  // namespace pliant
