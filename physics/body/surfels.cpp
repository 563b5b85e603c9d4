#include "physics/body/surfels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "gaussians/base/nearest.h"
#include "gaussians/base/polar.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"
#include "physics/body/strands.h"

namespace pliant {
namespace {

constexpr int kNeighbours = 10;
constexpr float kPi = 3.14159265f, kGoldenAngle = 2.39996323f;
constexpr int kDiscPoints = 32;  // that measure how much of a disc is covered
constexpr float kReach = 2;      // standard deviations to which a Gaussian is surface

/// Opaque discs in a uniform grid, for short visibility queries.
class DiscGrid {
 public:
  DiscGrid(const std::vector<Surfel>& surfels, const std::vector<float>& radius) : surfels_(surfels), radius_(radius) {
    for (size_t i = 0; i < surfels.size(); ++i) {
      box_.add(surfels[i].position - Vec3f::Constant(radius[i]));
      box_.add(surfels[i].position + Vec3f::Constant(radius[i]));
    }
    cell_ = std::max(1.5f * quantile(radius, 0.5), box_.size().maxCoeff() / kMaxSide);
    if (!(cell_ > 0)) cell_ = 1;  // points at one place
    for (int a = 0; a < 3; ++a) side_[a] = static_cast<int>(box_.size()[a] / cell_) + 1;
    // Counting sort of (cell, disc) pairs.
    begin_.assign(static_cast<size_t>(side_[0]) * side_[1] * side_[2] + 1, 0);
    for (int pass = 0; pass < 2; ++pass) {
      for (size_t i = 0; i < surfels.size(); ++i) {
        for_cells(i, [&](size_t cell) {
          if (pass == 0)
            ++begin_[cell + 1];
          else
            disc_[cursor_[cell]++] = static_cast<int>(i);
        });
      }
      if (pass == 1) break;
      for (size_t c = 1; c < begin_.size(); ++c) begin_[c] += begin_[c - 1];
      cursor_.assign(begin_.begin(), begin_.end());
      disc_.resize(begin_.back());
    }
  }

  /// Whether the ray from x along unit d leaves the grid without meeting a disc.
  bool escapes(const Vec3f& x, const Vec3f& d) const {
    // Amanatides and Woo (1987).
    int at[3], step[3];
    float next[3], delta[3];
    for (int a = 0; a < 3; ++a) {
      const float u = (x[a] - box_.low[a]) / cell_;
      at[a] = static_cast<int>(std::floor(u));
      step[a] = d[a] >= 0 ? 1 : -1;
      const float inverse = 1 / std::max(std::abs(d[a]), 1e-12f);
      delta[a] = cell_ * inverse;
      next[a] = (d[a] >= 0 ? at[a] + 1 - u : u - at[a]) * cell_ * inverse;
    }
    for (;;) {
      for (int a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= side_[a]) return true;
      const size_t cell = (static_cast<size_t>(at[0]) * side_[1] + at[1]) * side_[2] + at[2];
      for (int k = begin_[cell]; k < begin_[cell + 1]; ++k) {
        const Surfel& s = surfels_[disc_[k]];
        const float facing = s.normal.dot(d);
        if (std::abs(facing) < 0.05f) continue;
        const float t = s.normal.dot(s.position - x) / facing;
        if (t <= 0) continue;
        const float r = radius_[disc_[k]];
        if ((x + t * d - s.position).squaredNorm() < r * r) return false;
      }
      const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      at[a] += step[a];
      next[a] += delta[a];
    }
  }

 private:
  static constexpr int kMaxSide = 160, kMaxCells = 6;

  template <class F>
  void for_cells(size_t i, F&& f) const {
    int low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      const float u = (surfels_[i].position[a] - box_.low[a]) / cell_,
                  r = std::min(radius_[i] / cell_, 0.5f * kMaxCells);
      low[a] = std::clamp(static_cast<int>(u - r), 0, side_[a] - 1);
      high[a] = std::clamp(static_cast<int>(u + r), 0, side_[a] - 1);
    }
    for (int x = low[0]; x <= high[0]; ++x)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) f((static_cast<size_t>(x) * side_[1] + y) * side_[2] + z);
  }

  const std::vector<Surfel>& surfels_;
  const std::vector<float>& radius_;
  Box box_;
  float cell_;
  int side_[3];
  std::vector<int> begin_, cursor_, disc_;
};

/// A piece of a round rod with the volume of the strand.
void make_rod(const Strand& strand, Surfel& s) {
  s.along = strand.along;
  for (int a = 0; a < 2; ++a) s.extent[a] = strand.across[a];
  s.normal = strand.across[0].normalized();
  s.side = 0;
  s.thickness = strand.diameter();
  s.area = s.sheet_area = kPi / 4 * strand.diameter() * strand.length;
}

/// Directions spread evenly over the sphere (spherical Fibonacci).
std::vector<Vec3f> sphere_directions(int count) {
  std::vector<Vec3f> directions;
  for (int k = 0; k < count; ++k) {
    const float z = 1 - (2 * k + 1.0f) / count, r = std::sqrt(1 - z * z), angle = kGoldenAngle * k;
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

/// Turns every normal to the side on which more rays escape.
void orient(std::vector<Surfel>& surfels, const std::vector<float>& radius) {
  const DiscGrid grid(surfels, radius);
  const std::vector<Vec3f> directions = sphere_directions(24);
  std::vector<float> side(surfels.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(surfels.size()),
      [&](std::ptrdiff_t i) {
        const Surfel& s = surfels[i];
        int open[2] = {0, 0}, cast[2] = {0, 0};
        for (const Vec3f& d : directions) {
          const float facing = d.dot(s.normal);
          if (std::abs(facing) < 0.25f) continue;
          const int k = facing > 0;
          ++cast[k];
          open[k] += grid.escapes(s.position + (k ? 0.3f : -0.3f) * radius[i] * s.normal, d);
        }
        side[i] =
            static_cast<float>(open[1]) / std::max(cast[1], 1) - static_cast<float>(open[0]) / std::max(cast[0], 1);
      },
      64);
  for (size_t i = 0; i < surfels.size(); ++i) {
    if (side[i] < 0) surfels[i].normal = -surfels[i].normal;
    surfels[i].side = std::abs(side[i]);
  }
}

}  // namespace

std::vector<Surfel> make_surfels(const SurfelOptions& options, const GaussianCloud& cloud) {
  std::vector<int> visible;
  for (size_t i = 0; i < cloud.size(); ++i)
    if (sigmoid(cloud.opacity_logit[i]) >= options.opacity_threshold) visible.push_back(static_cast<int>(i));
  if (static_cast<int>(visible.size()) > options.max_count) {
    const double keep = static_cast<double>(options.max_count) / visible.size();
    std::erase_if(visible, [&](int i) { return Random(options.seed, i, 1).uniform() >= keep; });
  }

  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(visible.size());
  if (n == 0) return {};
  std::vector<Vec3f> position(n);
  std::vector<Mat3f> covariance(n);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    position[i] = cloud.position[visible[i]];
    const Mat3f A = rotation_matrix<float>(cloud.rotation[visible[i]]) *
                    cloud.log_scale[visible[i]].array().exp().matrix().asDiagonal();
    covariance[i] = A * A.transpose();
  }
  const NearestPoints tree(position);
  std::vector<Surfel> surfels(n);
  std::vector<float> radius(n);
  std::vector<std::optional<Strand>> strand(n);
  parallel_for(
      n,
      [&](std::ptrdiff_t i) {
        thread_local std::vector<NearestPoints::Hit> hits;
        tree.query(position[i], kNeighbours + 1, hits);
        Vec3f mean = Vec3f::Zero();
        for (const auto& hit : hits) mean += position[hit.index] / static_cast<float>(hits.size());
        Mat3f own = Mat3f::Zero(), spread = Mat3f::Zero();
        for (const auto& hit : hits) {
          const Vec3f d = position[hit.index] - mean;
          own += covariance[hit.index] / static_cast<float>(hits.size());
          spread += d * d.transpose() / static_cast<float>(hits.size());
        }
        constexpr float kFlat = 0.25f;  // ratio of variances below which Gaussians tell the normal themselves
        Vec3f value;
        Mat3f axes;
        symmetric_eigen<float, 3>(own, value, axes);
        if (value[0] > kFlat * value[1]) symmetric_eigen<float, 3>(own + spread, value, axes);
        Surfel& s = surfels[i];
        s.position = position[i];
        s.normal = axes.col(0);
        symmetric_eigen<float, 3>(covariance[i], value, axes);
        for (int a = 0; a < 2; ++a) s.extent[a] = std::sqrt(std::max(0.0f, value[2 - a])) * axes.col(2 - a);
        // Discs of this radius cover a surface that is sampled at random; none reaches far beyond its own Gaussian.
        radius[i] = kReach * std::sqrt(covariance[i].trace());
        if (hits.size() > 1) radius[i] = std::min(radius[i], 0.7f * hits.back().distance);
        strand[i] = strand_at(static_cast<int>(i), position, covariance, tree, hits);
      },
      256);
  orient(surfels, radius);
  for (std::ptrdiff_t i = 0; i < n; ++i)
    if (strand[i]) make_rod(*strand[i], surfels[i]);

  std::optional<NearestPoints> outside;
  if (options.outset != 0) {
    for (std::ptrdiff_t i = 0; i < n; ++i)
      if (surfels[i].one_sided()) surfels[i].position = position[i] += options.outset * surfels[i].normal;
    outside.emplace(position);
  }
  const NearestPoints& moved = outside ? *outside : tree;
  parallel_for(
      n,
      [&](std::ptrdiff_t i) {
        if (strand[i]) return;
        thread_local std::vector<NearestPoints::Hit> hits;
        moved.query(position[i], 3 * kNeighbours, hits);
        // sigma_1 sigma_2 of a flat Gaussian, from the second invariant of its covariance.
        const Mat3f& S = covariance[i];
        const float footprint =
            kPi * kReach * kReach * std::sqrt(0.5f * std::max(0.0f, S.trace() * S.trace() - S.squaredNorm()));
        const auto area_of = [&](auto&& counts) {
          std::vector<int> same = {static_cast<int>(i)};
          float reach = 0;
          for (const auto& hit : hits) {
            if (hit.index == i || !counts(surfels[hit.index])) continue;
            same.push_back(hit.index);
            reach = hit.distance;
            if (same.size() == kNeighbours + 1) break;
          }
          if (same.size() == 1) return footprint;
          // What they cover of the disc that holds them: little of it in a narrow strip or at an edge.
          const Vec3f normal = surfels[i].normal, u = normal.unitOrthogonal(), v = normal.cross(u);
          int covered = 0;
          for (int k = 0; k < kDiscPoints; ++k) {
            const float r = reach * std::sqrt((k + 0.5f) / kDiscPoints), angle = kGoldenAngle * static_cast<float>(k);
            const Vec3f x = position[i] + r * (std::cos(angle) * u + std::sin(angle) * v);
            covered += std::any_of(same.begin(), same.end(), [&](int j) {
              const Vec3f d = x - position[j];
              return (d - d.dot(normal) * normal).squaredNorm() < radius[j] * radius[j];
            });
          }
          const float share = static_cast<float>(std::max(covered, 1)) / kDiscPoints;
          return std::min(footprint, share * kPi * reach * reach / static_cast<float>(same.size() - 1));
        };
        surfels[i].area =
            area_of([&](const Surfel& s) { return s.one_sided() && s.normal.dot(surfels[i].normal) > 0.2f; });
        // Only what lies on the Gaussian itself belongs to its layer.
        const Vec3f& normal = surfels[i].normal;
        float depth = 0;
        int count = 0;
        for (const auto& hit : hits) {
          if (hit.distance > radius[i] || std::abs(surfels[hit.index].normal.dot(normal)) < 0.7f) continue;
          const float d = normal.dot(position[hit.index] - position[i]);
          depth += d * d;
          ++count;
        }
        surfels[i].thickness =
            std::sqrt(12 * (normal.dot(S * normal) + depth / static_cast<float>(std::max(count, 1))));
        surfels[i].sheet_area =
            area_of([&](const Surfel& s) { return std::abs(s.normal.dot(surfels[i].normal)) > 0.2f; });
      },
      256);
  return surfels;
}

}  // namespace pliant
