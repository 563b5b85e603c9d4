#include "physics/body/interior_fill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"
#include "physics/body/surfels.h"
#include "physics/body/winding_number.h"

namespace pliant {
namespace {

constexpr float kInside = 0.5f;      // winding number of the surface itself
constexpr float kSeen = 4;           // spacings within which the thickness of a part is measured
constexpr float kEnclosing = 0.65f;  // a lone sheet reaches 1/2 on one side; more means that it is closed behind

struct Cell {
  int x, y, z;
  bool whole;  // lies inside, away from the surface
};

/// Cells of side h that may hold something, found by halving cubes that a surfel may cross.
class CellSearch {
 public:
  CellSearch(const std::vector<Vec3f>& surface, const WindingNumber& winding, const Vec3f& low, float h, float margin)
      : nearest_(surface), winding_(winding), low_(low), h_(h), margin_(margin) {}

  std::vector<Cell> find(int levels) {
    if (!winding_.empty()) split(0, 0, 0, 1 << levels);
    return std::move(cells_);
  }

 private:
  void split(int x, int y, int z, int side) {
    const Vec3f centre = low_ + h_ * (Vec3f(x, y, z) + Vec3f::Constant(0.5f * side));
    nearest_.query(centre, 1, hits_);
    if (hits_[0].distance > 0.8660254f * side * h_ + margin_) {
      if (winding_.at(centre) <= kInside) return;
      for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
          for (int k = 0; k < side; ++k) cells_.push_back({x + i, y + j, z + k, true});
    } else if (side == 1) {
      cells_.push_back({x, y, z, false});
    } else {
      const int half = side / 2;
      for (int o = 0; o < 8; ++o) split(x + (o >> 2) * half, y + (o >> 1 & 1) * half, z + (o & 1) * half, half);
    }
  }

  NearestPoints nearest_;
  const WindingNumber& winding_;
  Vec3f low_;
  float h_, margin_;
  std::vector<NearestPoints::Hit> hits_;
  std::vector<Cell> cells_;
};

/// One sample per cell at the mean of the jittered points of the cell that lie inside, with their share of its volume.
void sample_inside(const std::vector<Cell>& cells, const WindingNumber& winding, const Vec3f& low, float h,
                   uint64_t seed, SolidSamples& samples) {
  constexpr int kSide = 2, kPoints = kSide * kSide * kSide;
  std::vector<Vec3f> position(cells.size());
  std::vector<float> volume(cells.size(), 0.0f);
  parallel_for(
      static_cast<std::ptrdiff_t>(cells.size()),
      [&](std::ptrdiff_t c) {
        const Cell& cell = cells[c];
        Random random(seed, (static_cast<uint64_t>(cell.x) << 42) ^ (static_cast<uint64_t>(cell.y) << 21) ^ cell.z);
        const auto jitter = [&] {
          const double x = random.uniform(), y = random.uniform(), z = random.uniform();
          return Vec3f(x, y, z);
        };
        const Vec3f corner = low + h * Vec3f(cell.x, cell.y, cell.z);
        if (cell.whole) {
          position[c] = corner + h * jitter();
          volume[c] = h * h * h;
          return;
        }
        int inside = 0;
        Vec3f sum = Vec3f::Zero();
        for (int p = 0; p < kPoints; ++p) {
          const Vec3f x = corner + h / kSide * (Vec3f(p / (kSide * kSide), p / kSide % kSide, p % kSide) + jitter());
          if (winding.at(x) > kInside) {
            ++inside;
            sum += x;
          }
        }
        if (inside > 0) {
          position[c] = sum / inside;
          volume[c] = h * h * h * inside / kPoints;
        }
      },
      64);
  for (size_t c = 0; c < cells.size(); ++c)
    if (volume[c] > 0) {
      samples.position.push_back(position[c]);
      samples.volume.push_back(volume[c]);
    }
}

/// Surfels that bound no inside: the winding number is near 1 on neither side.
std::vector<uint8_t> find_sheets(const std::vector<Surfel>& surfels, const WindingNumber& winding) {
  std::vector<uint8_t> thin(surfels.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(surfels.size()),
      [&](std::ptrdiff_t i) {
        const Surfel& s = surfels[i];
        float largest = 0;
        for (const float step : {0.25f, 0.5f, 0.75f, 1.0f, 1.5f, 2.0f})
          for (const float side : {-1.0f, 1.0f})
            largest = std::max(largest, winding.at(s.position + side * step * std::sqrt(s.area) * s.normal));
        thin[i] = largest < kEnclosing;
      },
      64);
  return thin;
}

/// Adds surfels of which no solid sample lies near, so that no part of the object is left without samples.
void add_uncovered(const std::vector<Surfel>& surfels, const SolidSamples& solid, std::vector<uint8_t>& thin) {
  if (solid.size() == 0) {
    std::fill(thin.begin(), thin.end(), 1);
    return;
  }
  const NearestPoints tree(solid.position);
  parallel_for(
      static_cast<std::ptrdiff_t>(surfels.size()),
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        tree.query(surfels[i].position, 1, hits);
        if (hits[0].distance > std::max(2 * solid.spacing, std::sqrt(surfels[i].area))) thin[i] = 1;
      },
      256);
}

std::vector<Surfel> select(const std::vector<Surfel>& surfels, const std::vector<uint8_t>& chosen) {
  std::vector<Surfel> out;
  for (size_t i = 0; i < surfels.size(); ++i)
    if (chosen[i]) out.push_back(surfels[i]);
  return out;
}

float sheet_thickness(const Surfel& s) { return std::max(s.thickness, 0.05f * std::sqrt(s.sheet_area)); }

/// Points about `step` apart across the uniform ellipse that has the variance of a surfel's Gaussian, in a strand along
/// its axis as well.
void points_across(const Surfel& s, float step, std::vector<Vec3f>& points) {
  constexpr float kRadius = 2;                   // standard deviations
  const int most = s.along.isZero(0) ? 64 : 16;  // points to either side of the middle
  points.clear();
  const auto count_along = [&](const Vec3f& axis) {
    return std::min(most, static_cast<int>(std::lround(kRadius * axis.norm() / step)));
  };
  const int count[3] = {count_along(s.extent[0]), count_along(s.extent[1]), count_along(s.along)};
  for (int i = -count[0]; i <= count[0]; ++i)
    for (int j = -count[1]; j <= count[1]; ++j) {
      const float u = static_cast<float>(i) / std::max(count[0], 1), v = static_cast<float>(j) / std::max(count[1], 1);
      if (u * u + v * v > 1) continue;
      const Vec3f middle = s.position + kRadius * (u * s.extent[0] + v * s.extent[1]);
      for (int k = -count[2]; k <= count[2]; ++k)
        points.push_back(middle + kRadius * static_cast<float>(k) / std::max(count[2], 1) * s.along);
    }
}

/// One sample per cell of side h that sheets cross, at the weighted mean of what lies in it.
void sample_sheets(const std::vector<Surfel>& sheets, const Vec3f& low, float h, SolidSamples& samples) {
  struct Sum {
    Vec3d position = Vec3d::Zero();
    double volume = 0, area = 0;
  };
  std::map<std::array<int, 3>, Sum> cells;
  std::vector<Vec3f> points;
  for (const Surfel& s : sheets) {
    if (!(s.sheet_area > 0)) continue;  // needles and Gaussians that coincide have no area
    points_across(s, h, points);
    const double area = static_cast<double>(s.sheet_area) / static_cast<double>(points.size());
    const double volume = area * sheet_thickness(s);
    for (const Vec3f& x : points) {
      const Vec3f u = (x - low) / h;
      const auto floor_of = [](float f) { return static_cast<int>(std::floor(f)); };
      Sum& sum = cells[{floor_of(u.x()), floor_of(u.y()), floor_of(u.z())}];
      sum.position += volume * x.cast<double>();
      sum.volume += volume;
      sum.area += area;
    }
  }
  for (const auto& [cell, sum] : cells) {
    samples.position.push_back((sum.position / sum.volume).cast<float>());
    samples.volume.push_back(static_cast<float>(sum.volume));
    samples.thickness.push_back(static_cast<float>(sum.volume / sum.area));
  }
}

/// Thickness of the solid around each sample: twice the largest distance from the surface among samples within kSeen
/// spacings; 0 where that reaches beyond them, because more is not seen.
void measure_thickness(const std::vector<Surfel>& surfels, const std::vector<Vec3f>& surface, SolidSamples& samples) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(samples.size());
  const float reach = kSeen * samples.spacing;
  const NearestPoints walls(surface), others(samples.position);
  std::vector<float> depth(n);
  parallel_for(
      n,
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        walls.query(samples.position[i], 1, hits);
        const Surfel& s = surfels[hits[0].index];
        depth[i] = std::abs(s.normal.dot(samples.position[i] - s.position));
      },
      256);
  samples.thickness.assign(n, 0.0f);
  parallel_for(
      n,
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        others.around(samples.position[i], reach, hits);
        float deepest = 0;
        for (const auto& hit : hits) deepest = std::max(deepest, depth[hit.index]);
        if (deepest < reach) samples.thickness[i] = std::max(2 * deepest, 0.5f * samples.spacing);
      },
      256);
}

}  // namespace

SolidSamples fill_interior(const FillOptions& options, const GaussianCloud& object, FillSummary* summary) {
  if (options.target_count < 1 || options.max_cells < 8)
    throw usage_error("seed", "target_count", "or max_cells is too small", "use the defaults");
  const std::vector<Surfel> surfels =
      make_surfels({options.opacity_threshold, options.max_surfels, options.outset, options.seed}, object);
  if (surfels.empty())
    throw usage_error("seed", "object", "has no visible Gaussian", "select an object whose Gaussians are opaque");
  const WindingNumber winding(surfels);
  std::vector<uint8_t> thin = find_sheets(surfels, winding);

  std::vector<Vec3f> surface;
  std::vector<float> spacing;
  Box box;
  for (const Surfel& s : surfels) {
    surface.push_back(s.position);
    spacing.push_back(std::sqrt(s.area));
    box.add(s.position);
  }
  const float margin = 2 * quantile(std::move(spacing), 0.5);
  const float longest = std::max(box.size().maxCoeff(), 1e-6f) + 2 * margin;
  const Vec3f low = box.low - Vec3f::Constant(margin);
  double sheet_volume = 0;
  for (const Surfel& s : select(surfels, thin)) sheet_volume += static_cast<double>(s.sheet_area) * sheet_thickness(s);

  // A coarse pass measures the volume, from which the cells of the wanted number of samples follow.
  const auto fill = [&](float h) {
    SolidSamples samples;
    const int levels = static_cast<int>(std::ceil(std::log2(longest / h)));
    CellSearch search(surface, winding, low, h, margin);
    sample_inside(search.find(std::max(levels, 0)), winding, low, h, options.seed, samples);
    return samples;
  };
  const double coarse = fill(longest / 48).total_volume() + sheet_volume;
  const float h = std::max(static_cast<float>(std::cbrt(coarse / options.target_count)), longest / options.max_cells);
  SolidSamples samples = fill(h);
  samples.spacing = h;
  measure_thickness(surfels, surface, samples);
  const size_t solid = samples.size();
  add_uncovered(surfels, samples, thin);
  sample_sheets(select(surfels, thin), low, h, samples);
  if (samples.size() == 0)
    throw usage_error("seed", "object", "has no volume", "select an object whose Gaussians lie apart");
  if (summary) {
    *summary = {};
    summary->volume = samples.total_volume();
    summary->samples = samples.size();
    summary->cell = h;
    summary->thin_samples = samples.size() - solid;
  }
  return samples;
}

}  // namespace pliant
