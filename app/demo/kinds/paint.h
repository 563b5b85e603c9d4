#pragma once

#include <cstdint>

#include "gaussians/base/random.h"
#include "gaussians/base/types.h"

namespace pliant {

/// Texture of planks on the plane: boards along u in two tones with soft grain.  Periodic in u and v.
constexpr double kPlankPeriodU = 0.24, kPlankPeriodV = 0.16;  // metres
Vec3d planks(double u, double v, const Vec3d& wood);

/// Texture of square tiles in two tones with grout lines.  Periodic in u and v.
constexpr double kTilePeriod = 0.20;  // metres
Vec3d tiles(double u, double v, const Vec3d& glaze);

/// Smooth noise in [-1, 1] over space (values on a lattice, interpolated with a C1 polynomial); lattice step 1.
double lattice_noise(const Vec3d& x, uint64_t seed);

/// A colour near one of the palette's.
template <size_t N>
Vec3d pick_colour(Random& random, const Vec3d (&palette)[N]) {
  return palette[random.below(N)] + 0.03 * Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}

/// How a surface is painted; coordinates are those of its own frame at rest.
struct Paint {
  enum class Kind {
    kPlain,
    kPlanks,
    kTiles,
    kBands,   ///< of the accent around z
    kGraded,  ///< from the albedo at x = 0 to the accent at x = period
    kVeined,  ///< a midrib along x and side veins of the accent, `period` apart
    kKnit,    ///< rows of stitches along x, `period` long
    kPlaid,   ///< two sets of stripes of the accent over x and z, `period` apart
    kSpots,   ///< of the accent, a third of a period wide
  } kind = Kind::kPlain;
  Vec3d albedo = Vec3d::Constant(0.5);
  Vec3d accent = Vec3d::Constant(0.5);  ///< second tone
  double grain = 0.012;                 ///< wavelength of the mottling [m]
  uint64_t seed = 0;
  double period = 0.02;  ///< [m]
};

/// Reflected colour of a point before shading, in [0, 1].  `normal` is in the same frame as x.
Vec3d albedo_at(const Paint& paint, const Vec3d& x, const Vec3d& normal);

/// Baked diffuse shade of a surface with this world normal: one lamp from the upper left in front, and an ambient part.
double baked_shade(const Vec3d& world_normal);

}  // namespace pliant
