#include "segmentation/discover/automatic_supports.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "gaussians/base/error.h"
#include "gaussians/base/morton.h"
#include "gaussians/base/orbit.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"
#include "segmentation/discover/support_candidate.h"
#include "segmentation/graph/contact.h"

namespace pliant {
namespace {

constexpr int kSamples = 12000;
constexpr int kGroundTries = 4;
constexpr int kCells = 64;         // of the grid for areas, along the diagonal;
constexpr float kWideCells = 2;    // so many times as wide where areas are compared cell by cell
constexpr float kLow = 0.25f;      // of the diagonal: what is higher above a ground is a ceiling
constexpr float kUpright = 0.35f;  // cosine between the normals of a wall and of the ground

/// Extent of points along a direction, 2nd to 98th percentile.
float width_along(const std::vector<Vec3f>& points, const Vec3f& direction) {
  if (points.empty()) return 0;
  std::vector<float> values;
  for (const Vec3f& x : points) values.push_back(direction.dot(x));
  return quantile(values, 0.98) - quantile(values, 0.02);
}

/// Cells of a grid across `normal` that hold points.
std::set<std::pair<int, int>> occupied_cells(const std::vector<Vec3f>& points, const Vec3f& normal, float cell) {
  const Vec3f u = normal.unitOrthogonal(), v = normal.cross(u);
  std::set<std::pair<int, int>> cells;
  const auto index = [&](float x) { return static_cast<int>(std::clamp(std::floor(x / cell), -1e6f, 1e6f)); };
  for (const Vec3f& x : points) cells.insert({index(u.dot(x)), index(v.dot(x))});
  return cells;
}

/// Share of the plane's cells that hold no point above the plane, up to the height `low`.
float open_share(const SupportCandidate& plane, float cell, float low) {
  std::vector<Vec3f> over;
  for (const Vec3f& x : plane.above)
    if (plane.support.height(x) <= low) over.push_back(x);
  const auto own = occupied_cells(plane.inside, plane.support.normal, cell),
             covered = occupied_cells(over, plane.support.normal, cell);
  const auto open = std::count_if(own.begin(), own.end(), [&](const auto& at) { return covered.count(at) == 0; });
  return own.empty() ? 0 : static_cast<float>(open) / static_cast<float>(own.size());
}

/// The lowest planes that can be the ground: with next to nothing below beside what is above, or beside the plane.
struct Grounds {
  std::optional<SupportCandidate> by_things, by_itself;
};

/// With so thick a consensus.  A slab through a body is none: the body goes on above most of it.
Grounds lowest_grounds(const SupportOptions& options, const std::vector<Vec3f>& samples, const Vec3f& up,
                       float tolerance, float cell) {
  Grounds grounds;
  std::vector<Vec3f> left = samples;
  for (int k = 0; k < kGroundTries && left.size() >= kFewestOfPlane; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + k, up, options.tilt);
    if (plane.inliers.size() < kFewestOfPlane) break;
    SupportCandidate found(plane, tolerance, plane.normal, samples);
    remove_near_support(found.support, tolerance, left);
    const size_t above = occupied_cells(found.above, plane.normal, cell).size();
    const bool by_things = found.share_below() <= options.below;
    const bool by_itself = static_cast<float>(found.below) <= options.below * static_cast<float>(found.inside.size());
    if (found.support.share < options.ground_share || (!by_things && !by_itself)) continue;
    if (static_cast<float>(occupied_cells(found.inside, plane.normal, cell).size()) <
        options.ground_area * static_cast<float>(above))
      continue;
    if (open_share(found, kWideCells * cell, kLow * kCells * cell) < options.ground_open) continue;
    std::optional<SupportCandidate>& ground = by_things ? grounds.by_things : grounds.by_itself;
    if (!ground || up.dot(found.support.point - ground->support.point) < 0) ground = std::move(found);
  }
  return grounds;
}

/// Points drawn from the scene along a curve through space, so that they are about the same ones for any order and
/// origin of the Gaussians.
std::vector<Vec3f> draw_in_space(const SolidScene& scene, uint64_t seed) {
  std::vector<Vec3f> position;
  std::vector<float> mass;
  for (const int i : morton_order(scene.cloud.position)) {
    position.push_back(scene.cloud.position[i]);
    mass.push_back(scene.mass[i]);
  }
  return draw_points(position, mass, seed);
}

}  // namespace

std::vector<Vec3f> draw_points(std::span<const Vec3f> position, std::span<const float> mass, uint64_t seed) {
  CHECK(position.size() == mass.size());
  std::vector<double> cumulative(mass.size());
  double total = 0;
  for (size_t i = 0; i < mass.size(); ++i) cumulative[i] = total += mass[i];
  std::vector<Vec3f> samples;
  if (!(total > 0)) return samples;
  Random random(seed);
  for (int k = 0; k < kSamples; ++k) {
    const auto at = std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * total);
    samples.push_back(position[std::min<size_t>(at - cumulative.begin(), position.size() - 1)]);
  }
  return samples;
}

std::vector<Support> find_supports(const SupportOptions& options, const SolidScene& scene, const Vec3f& up) {
  const std::vector<Vec3f> samples = draw_in_space(scene, options.seed);
  if (samples.size() < kFewestOfPlane) return {};
  const float diagonal = static_cast<float>(robust_framing(scene.cloud, up.cast<double>()).diagonal());
  const float tolerance = std::max(options.tolerance * diagonal, scene.graph.spacing),
              cell = std::max(diagonal / kCells, 1e-12f);

  std::optional<SupportCandidate> ground, by_itself;
  float thickness = tolerance, thickness_by_itself = tolerance;
  for (float rough = 1; rough <= options.roughest && !ground; rough *= 2) {
    thickness = rough * tolerance;
    Grounds found = lowest_grounds(options, samples, up, thickness, cell);
    ground = std::move(found.by_things);
    if (by_itself || !found.by_itself) continue;
    by_itself = std::move(found.by_itself);
    thickness_by_itself = thickness;
  }
  if (!ground) {
    ground = std::move(by_itself);
    thickness = thickness_by_itself;
  }
  if (!ground) return {};
  ground->settle(scene.graph.spacing);
  std::vector<Support> supports = {ground->support};

  std::vector<Vec3f> left = samples;
  remove_near_support(supports[0], thickness, left);
  for (int k = 0; k < options.most_walls && left.size() >= kFewestOfPlane; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + 100 + k);
    if (plane.inliers.size() < kFewestOfPlane) break;
    SupportCandidate wall(plane, tolerance, plane.normal, samples);
    if (wall.below > wall.above.size()) wall = SupportCandidate(plane, tolerance, -plane.normal, samples);
    remove_near_support(wall.support, tolerance, left);
    const Vec3f across = supports[0].normal.cross(wall.support.normal);
    if (wall.support.share < options.wall_share || wall.share_below() > options.behind ||
        across.norm() < std::sqrt(1 - kUpright * kUpright) ||
        width_along(wall.inside, across.normalized()) <
            options.wall_width * width_along(ground->inside, across.normalized()))
      continue;
    wall.settle(scene.graph.spacing);
    wall.support.wall = true;
    supports.push_back(wall.support);
  }
  return supports;
}

}  // namespace pliant
