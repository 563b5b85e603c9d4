#include "app/demo/kinds/paint.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pliant {
namespace {

double wave(double turns) { return std::sin(2 * std::numbers::pi * turns); }
double fraction(double x) { return x - std::floor(x); }
double smoothstep(double x) {
  x = std::clamp(x, 0.0, 1.0);
  return x * x * (3 - 2 * x);
}
/// 0 on the lines between cells of width `cell`, 1 farther than `line` from them.
double off_line(double x, double cell, double line) {
  const double f = fraction(x / cell) * cell;
  return smoothstep(std::min(f, cell - f) / line);
}

double lattice_value(int64_t i, int64_t j, int64_t k, uint64_t seed) {
  uint64_t h = seed + 0x9e3779b97f4a7c15ull * static_cast<uint64_t>(i + 4096) +
               0xc2b2ae3d27d4eb4full * static_cast<uint64_t>(j + 4096) +
               0x165667b19e3779f9ull * static_cast<uint64_t>(k + 4096);
  h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 29)) * 0x94d049bb133111ebull;
  return static_cast<double>((h ^ (h >> 32)) & 0xffffff) / 0x7fffff - 1.0;
}

}  // namespace

Vec3d planks(double u, double v, const Vec3d& wood) {
  const double board = kPlankPeriodV / 2;
  const bool odd = fraction(v / kPlankPeriodV) >= 0.5;
  const double su = u / kPlankPeriodU + (odd ? 0.37 : 0.0), sv = v / board;
  const double grain = 0.045 * wave(2 * su + 0.35 * wave(sv)) + 0.03 * wave(3 * sv + 0.5 * wave(su));
  const double tone = (odd ? 0.88 : 1.0) * (1 + grain) * (0.62 + 0.38 * off_line(v, board, 0.005));
  return wood * tone;
}

Vec3d tiles(double u, double v, const Vec3d& glaze) {
  const double side = kTilePeriod / 2;
  const bool odd = (fraction(u / kTilePeriod) >= 0.5) != (fraction(v / kTilePeriod) >= 0.5);
  const double body = std::min(off_line(u, side, 0.006), off_line(v, side, 0.006));
  const double cloud = 1 + 0.03 * wave(u / kTilePeriod + 0.3 * wave(v / kTilePeriod));
  const Vec3d tile = glaze * (odd ? 0.86 : 1.0) * cloud, grout = Vec3d(0.80, 0.79, 0.76);
  return grout + body * (tile - grout);
}

double lattice_noise(const Vec3d& x, uint64_t seed) {
  const Vec3d base = x.array().floor(), f = x - base;
  const Vec3d s = f.array() * f.array() * (3 - 2 * f.array());
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int a = corner & 1, b = (corner >> 1) & 1, c = corner >> 2;
    const double weight = (a ? s.x() : 1 - s.x()) * (b ? s.y() : 1 - s.y()) * (c ? s.z() : 1 - s.z());
    sum += weight * lattice_value(static_cast<int64_t>(base.x()) + a, static_cast<int64_t>(base.y()) + b,
                                  static_cast<int64_t>(base.z()) + c, seed);
  }
  return sum;
}

Vec3d albedo_at(const Paint& paint, const Vec3d& x, const Vec3d& normal) {
  Vec3d colour = paint.albedo;
  switch (paint.kind) {
    case Paint::Kind::kPlanks:
      return planks(x.x(), x.y(), paint.albedo);
    case Paint::Kind::kTiles:
      // The plane of the wall is (x, z); its narrow sides continue the texture.
      return std::abs(normal.y()) > 0.5 ? tiles(x.x(), x.z(), paint.albedo) : Vec3d(paint.albedo * 0.9);
    case Paint::Kind::kBands:
      colour += smoothstep(3 * wave(x.z() / 0.05) + 0.5) * (paint.accent - paint.albedo);
      break;
    case Paint::Kind::kGraded:
      colour += smoothstep(x.x() / paint.period) * (paint.accent - paint.albedo);
      break;
    case Paint::Kind::kVeined: {
      // Side veins leave the midrib forwards.
      const double rib = 1 - smoothstep(std::abs(x.y()) / (0.12 * paint.period));
      const double side = 1 - off_line(x.x() - 0.8 * std::abs(x.y()), paint.period, 0.1 * paint.period);
      colour += std::max(rib, 0.7 * side) * (paint.accent - paint.albedo);
      break;
    }
    case Paint::Kind::kKnit: {
      // Each stitch is a V; the rows meet in dark lines.
      const double row =
          fraction((x.x() + 0.35 * std::abs(wave(0.5 * x.y() / paint.period)) * paint.period) / paint.period);
      const double stitch = std::abs(wave(x.y() / paint.period));
      colour = (0.68 + 0.32 * smoothstep(2 * std::min(row, 1 - row)) * (0.6 + 0.4 * stitch)) * paint.albedo;
      if (std::fmod(std::abs(std::floor(x.x() / paint.period)), 4.0) < 1) colour = 0.5 * (colour + paint.accent);
      break;
    }
    case Paint::Kind::kPlaid: {
      const double u = fraction(x.x() / paint.period), v = fraction(x.z() / paint.period);
      const double share = 0.45 * ((u < 0.4) + (v < 0.4)) + 0.1 * ((u > 0.62 && u < 0.7) + (v > 0.62 && v < 0.7));
      colour += std::min(share, 1.0) * (paint.accent - paint.albedo);
      break;
    }
    case Paint::Kind::kSpots:
      colour +=
          smoothstep(4 * lattice_noise(x * (3 / paint.period), paint.seed + 2) - 1.6) * (paint.accent - paint.albedo);
      break;
    case Paint::Kind::kPlain:
      break;
  }
  const double mottle =
      lattice_noise(x / paint.grain, paint.seed) + 0.5 * lattice_noise(x / (2.3 * paint.grain), paint.seed + 1);
  return colour * (1 + 0.16 * mottle);
}

double baked_shade(const Vec3d& world_normal) {
  static const Vec3d lamp = Vec3d(-0.45, -0.6, 0.75).normalized();
  return 0.52 + 0.46 * std::max(0.0, world_normal.dot(lamp));
}

}  // namespace pliant
