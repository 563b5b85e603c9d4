#include "app/demo/kinds/flower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/demo/kinds/pot.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
constexpr double kFrequency = 2.2;                            // Hz
constexpr double kPoisson = 0.28, kDensity = 700;             // -, kg/m^3
constexpr double kLeafSoftness = 8.2, kBlossomSoftness = 16;  // Young's modulus of the stem over that of the part

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
Beam beam_of(const Flower& flower, const ObjectSolid& samples) {
  Beam beam{flower.free_length, flower.base_diameter / 2, flower.tip_diameter / 2, {}};
  std::vector<Rider> riders(3);  // leaf on +x, leaf on -x, blossom with the dome of the stem
  for (size_t i = 0; i < samples.position.size(); ++i) {
    const Vec3d& x = samples.position[i];
    const double z = x.z() - flower.pin_height;
    if (samples.material[i] == kStem && z <= flower.free_length) continue;
    Rider& rider = riders[samples.material[i] == kLeaf ? (x.x() > 0 ? 0 : 1) : 2];
    const double mass = flower.solid(samples.material[i]).density * samples.cell * samples.cell * samples.cell;
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

const Vec3d kPetals[] = {{0.86, 0.32, 0.45}, {0.84, 0.72, 0.28}, {0.62, 0.38, 0.78}, {0.88, 0.50, 0.26}};

/// Paint of the piece with that index and tone; colours are drawn once.
struct FlowerPaints {
  Vec3d pot, petal, green;
  uint64_t seed;

  explicit FlowerPaints(uint64_t s) : seed(s) {
    Random random(seed, 3);
    place_object(random);  // the stream's first numbers
    pot = pick_colour(random, kPotColours);
    petal = pick_colour(random, kPetals);
    green = Vec3d(random.uniform(0.20, 0.30), random.uniform(0.46, 0.56), random.uniform(0.18, 0.26));
  }
  Paint of(FlowerPart part, int tone, size_t index) const {
    Paint paint{Paint::Kind::kPlain, pot, pot, 0.012, seed * 64 + 2 + index};
    if (part == kPot && tone == 1) {
      paint.albedo = kSoilColour;
      paint.grain = 0.007;
    }
    if (part == kStem) {
      paint.albedo = 0.9 * green;
      paint.grain = 0.010;
    }
    if (part == kLeaf) {
      paint.albedo = green + Vec3d(0.02, 0.10, 0.0) * tone;
      paint.grain = 0.010;
    }
    if (part == kBlossom) {
      const Vec3d heart = petal.y() > 0.6 ? Vec3d(0.48, 0.28, 0.14) : Vec3d(0.90, 0.72, 0.22);
      paint.albedo = tone == 0 ? heart : Vec3d(petal * (tone == 1 ? 1.0 : 0.90));
      paint.grain = 0.009;
    }
    return paint;
  }
};

}  // namespace

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
  const FlowerPaints paints(seed);
  std::vector<DemoPiece>& pieces = f.object.pieces;
  auto add = [&](FlowerPart part, std::unique_ptr<AnalyticShape> shape, const Isometry3d& pose, int tone) {
    pieces.push_back({part, std::move(shape), pose, paints.of(part, tone, pieces.size())});
  };
  const Isometry3d upright = Isometry3d::Identity();
  add(kPot, make_lathe(pot_profile(f.pot_radius, pot_height, f.soil_height)), upright, 0);
  add(kPot, make_lathe(soil_profile(f.pot_radius, f.soil_height, stem_radius(f.soil_height))), upright, 1);
  add(kStem, make_lathe(stem_profile(bottom, stem_radius(bottom), top, d / 2)), upright, 0);

  f.leaf_semi_axes = d * Vec3d(random.uniform(0.96, 1.04), 0.50, 0.31);
  for (int side = 0; side < 2; ++side) {
    const double azimuth = (180 * side + random.uniform(-20, 20)) * kDegree, rise = random.uniform(30, 40) * kDegree;
    const double height = f.pin_height + d * ((side ? 1.55 : 1.05) + random.uniform(-0.1, 0.1));
    const Vec3d out(std::cos(azimuth), std::sin(azimuth), 0),
        along = std::cos(rise) * out + std::sin(rise) * Vec3d::UnitZ();
    const Vec3d root(0, 0, height);
    const Vec3d centre = root + along * (0.55 * stem_radius(height) + f.leaf_semi_axes.x());
    add(kLeaf, make_ellipsoid(f.leaf_semi_axes), frame(centre, along, Vec3d::UnitZ().cross(out)), side);
  }

  // Petals stand around the axis of the blossom, which looks to the front and up.
  const double tilt = random.uniform(28, 42) * kDegree, phase = random.uniform(0, 60) * kDegree;
  const Vec3d facing(0, -std::cos(tilt), std::sin(tilt)), side(1, 0, 0), rising = side.cross(-facing);
  f.blossom_centre = Vec3d(0, 0, top) + 0.42 * d * facing;
  add(kBlossom, make_ellipsoid(d * Vec3d(0.30, 0.37, 0.37)), frame(f.blossom_centre + 0.10 * d * facing, facing, side),
      0);
  for (int k = 0; k < 6; ++k) {
    const double angle = phase + 60 * kDegree * k;
    const Vec3d radial = std::cos(angle) * side + std::sin(angle) * rising;
    add(kBlossom, make_ellipsoid(d * Vec3d(0.36, 0.29, 0.27)),
        frame(f.blossom_centre + 0.54 * d * radial, radial, facing.cross(radial)), 1 + k % 2);
  }

  DemoObject& object = f.object;
  object.name = "flower";
  for (const DemoPiece& piece : pieces)
    for (const SurfacePoint& p : piece.shape->cover(0.05 * d, seed)) {
      const Vec3d x = piece.object_from_local * p.position;
      object.height = std::max(object.height, x.z());
      object.reach = std::max(object.reach, x.head<2>().norm());
    }
  object.tip = f.blossom_centre;
  object.tip_radius = 1.2 * d;
  const double r = f.pot_radius + 0.01;
  object.pins = {Region::box({-r, -r, -0.01}, {r, r, f.pin_height})};

  // The frequency goes with the square root of Young's modulus.
  const auto material = [](const char* name, double softness) {
    DemoMaterial m;
    m.name = name;
    m.solid = {1e5 / softness, kPoisson, kDensity};
    return m;
  };
  object.materials = {material("pot", 1), material("stem", 1), material("leaf", kLeafSoftness),
                      material("blossom", kBlossomSoftness)};
  object.materials[kPot].fixed = true;
  const double scale = std::pow(kFrequency / flower_mechanics(f).frequency, 2);
  for (DemoMaterial& m : object.materials) m.solid.young *= scale;
  return f;
}

ObjectSolid sample_flower(const Flower& flower, double cell, double lowest, uint64_t seed) {
  const DemoObject& object = flower.object;
  return sample_solid(object.reach, object.height, cell, lowest, seed,
                      [&](const Vec3d& x) { return object.material_at(x); });
}

FlowerMechanics flower_mechanics(const Flower& flower) {
  FlowerMechanics m;
  const double d = flower.tip_diameter;
  const ObjectSolid above = sample_flower(flower, d / 20, flower.pin_height, 0);
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
  m.contrast = flower.solid(kStem).young / std::max(flower.solid(kLeaf).young, flower.solid(kBlossom).young);

  const Beam beam = beam_of(flower, above);
  m.frequency = first_frequency(beam, flower.solid(kStem));
  const BeamShape pushed = bend(beam, flower.solid(kStem), 0, {0, 0, 1});
  m.compliance = rider_deflection(beam, pushed, beam.riders[2]);

  const ElasticSolid& stem = flower.solid(kStem);
  const double nu = stem.poisson;
  const double modulus = stem.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));  // lambda + 2 mu
  m.substeps_4k = std::sqrt(modulus / stem.density) / (0.4 * m.cell_4k * 30);
  return m;
}

}  // namespace pliant
