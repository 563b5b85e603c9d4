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
#include "segmentation/graph/contact.h"

namespace pliant {
namespace {

constexpr int kSamples = 12000;
constexpr size_t kFewest = 30;  // samples of a plane
constexpr int kGroundTries = 4;
constexpr float kNoise = 3.5f;     // tolerance / standard deviation of a plane's points
constexpr int kCells = 64;         // of the grid for areas, along the diagonal;
constexpr float kWideCells = 2;    // so many times as wide where areas are compared cell by cell
constexpr float kLow = 0.25f;      // of the diagonal: what is higher above a ground is a ceiling
constexpr float kUpright = 0.35f;  // cosine between the normals of a wall and of the ground

/// A plane among the samples, and what lies on it and on its sides.
struct Candidate {
  Support support;
  std::vector<Vec3f> inside, above;
  size_t below = 0;

  Candidate(const Plane& plane, float tolerance, const Vec3f& normal, const std::vector<Vec3f>& samples) {
    support.point = plane.point;
    support.normal = normal;
    support.tolerance = tolerance;
    for (const Vec3f& x : samples) {
      const float h = support.height(x);
      if (std::abs(h) <= tolerance)
        inside.push_back(x);
      else if (h > 0)
        above.push_back(x);
      else
        ++below;
    }
    support.share = static_cast<double>(inside.size()) / static_cast<double>(samples.size());
  }
  double share_below() const {
    return below > 0 ? static_cast<double>(below) / static_cast<double>(below + above.size()) : 0;
  }

  /// The tolerance follows the noise of the plane's points, but not below the spacing of the Gaussians.
  void settle(float spacing) {
    std::vector<float> distance;
    for (const Vec3f& x : inside) distance.push_back(std::abs(support.height(x)));
    const float deviation = 1.4826f * quantile(distance, 0.5);
    support.tolerance = std::min(support.tolerance, std::max(kNoise * deviation, spacing));
  }
};

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
float open_share(const Candidate& plane, float cell, float low) {
  std::vector<Vec3f> over;
  for (const Vec3f& x : plane.above)
    if (plane.support.height(x) <= low) over.push_back(x);
  const auto own = occupied_cells(plane.inside, plane.support.normal, cell),
             covered = occupied_cells(over, plane.support.normal, cell);
  const auto open = std::count_if(own.begin(), own.end(), [&](const auto& at) { return covered.count(at) == 0; });
  return own.empty() ? 0 : static_cast<float>(open) / static_cast<float>(own.size());
}

void remove_near(const Support& support, float tolerance, std::vector<Vec3f>& points) {
  std::erase_if(points, [&](const Vec3f& x) { return std::abs(support.height(x)) <= tolerance; });
}

/// The lowest planes that can be the ground: with next to nothing below beside what is above, or beside the plane.
struct Grounds {
  std::optional<Candidate> by_things, by_itself;
};

/// With so thick a consensus.  A slab through a body is none: the body goes on above most of it.
Grounds lowest_grounds(const SupportOptions& options, const std::vector<Vec3f>& samples, const Vec3f& up,
                       float tolerance, float cell) {
  Grounds grounds;
  std::vector<Vec3f> left = samples;
  for (int k = 0; k < kGroundTries && left.size() >= kFewest; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + k, up, options.tilt);
    if (plane.inliers.size() < kFewest) break;
    Candidate found(plane, tolerance, plane.normal, samples);
    remove_near(found.support, tolerance, left);
    const size_t above = occupied_cells(found.above, plane.normal, cell).size();
    const bool by_things = found.share_below() <= options.below;
    const bool by_itself = static_cast<float>(found.below) <= options.below * static_cast<float>(found.inside.size());
    if (found.support.share < options.ground_share || (!by_things && !by_itself)) continue;
    if (static_cast<float>(occupied_cells(found.inside, plane.normal, cell).size()) <
        options.ground_area * static_cast<float>(above))
      continue;
    if (open_share(found, kWideCells * cell, kLow * kCells * cell) < options.ground_open) continue;
    std::optional<Candidate>& ground = by_things ? grounds.by_things : grounds.by_itself;
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

/// Whether two planes pass a thing at about the same height.
bool alike(const Support& a, const Support& b, const Vec3f& thing) {
  constexpr float kCosine = 0.98f;
  return a.normal.dot(b.normal) > kCosine &&
         std::abs(a.height(thing) - b.height(thing)) <= std::max(a.tolerance, b.tolerance);
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

std::vector<Support> planes_behind(const SupportOptions& options, const std::vector<Vec3f>& samples, const Vec3f& thing,
                                   float diagonal, float spacing) {
  std::vector<Support> planes;
  const float tolerance = std::max(options.tolerance * diagonal, spacing);
  std::vector<Vec3f> left = samples;
  for (int k = 0; k <= options.most_walls && left.size() >= kFewest; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + k);
    if (plane.inliers.size() < kFewest) break;
    const float side = plane.normal.dot(thing - plane.point) > 0 ? 1.0f : -1.0f;
    Candidate found(plane, tolerance, side * plane.normal, samples);
    remove_near(found.support, tolerance, left);
    found.support.share =
        static_cast<double>(plane.inliers.size()) / static_cast<double>(samples.size());  // not of planes before
    if (found.support.share < options.wide) continue;
    found.settle(spacing);
    // What counts is what lies behind the thing, not elsewhere: beside a table there is a floor.
    const Support& support = found.support;
    const float height = support.height(thing);
    const Vec3f foot = thing - height * support.normal;
    const float reach = std::max(options.around * height, 4 * tolerance);
    size_t on = 0, beyond = 0;
    for (const Vec3f& x : samples) {
      if ((x - foot).norm() > reach) continue;
      const float h = support.height(x);
      on += std::abs(h) <= support.tolerance;
      beyond += h < -support.tolerance;
    }
    if (height > options.clear * support.tolerance && on >= kFewest && beyond <= options.beyond * on)
      planes.push_back(support);
  }
  return planes;
}

std::vector<Support> planes_nearby(const SupportOptions& options, const ShownGaussians& gaussians, const Vec3f& thing,
                                   float diagonal, std::vector<Support> known) {
  std::vector<std::vector<Support>> found;  // from wide to near
  std::vector<Vec3f> position(gaussians.position.begin(), gaussians.position.end());
  std::vector<float> shown(gaussians.shown.begin(), gaussians.shown.end());
  std::vector<float> apart(gaussians.apart.begin(), gaussians.apart.end());
  SupportOptions nearby = options;
  nearby.beyond = INFINITY;
  float radius = diagonal / 2;
  for (int k = 0; k < options.nearer; ++k) {
    radius /= 2;
    size_t kept = 0;
    for (size_t i = 0; i < position.size(); ++i) {
      if ((position[i] - thing).squaredNorm() > radius * radius) continue;
      position[kept] = position[i];
      shown[kept] = shown[i];
      apart[kept++] = apart[i];
    }
    position.resize(kept);
    shown.resize(kept);
    apart.resize(kept);
    const std::vector<Vec3f> samples = draw_points(position, shown, options.seed);
    found.push_back(planes_behind(nearby, samples, thing, 2 * radius, quantile(apart, 0.5)));
  }
  // What was found near the thing is thinner and cuts less of its foot.
  std::vector<Support> planes;
  for (auto around = found.rbegin(); around != found.rend(); ++around)
    for (const Support& plane : *around) {
      if (std::any_of(known.begin(), known.end(), [&](const Support& k) { return alike(plane, k, thing); })) continue;
      planes.push_back(plane);
      known.push_back(plane);
    }
  return planes;
}

float share_beyond(const Support& plane, std::span<const Vec3f> position, std::span<const uint8_t> label) {
  constexpr int kSectors = 12, kFew = 3;  // points of the plane that a direction needs,
  constexpr float kClear = 1.1f;          // beyond so many times the thing's reach in that direction
  constexpr float kNear = 3;              // and within so many times its longest reach;
  constexpr double kReach = 0.95;         // so much of the thing lies within its reach
  const Vec3f u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  Vec3d sum = Vec3d::Zero();
  size_t count = 0;
  for (size_t p = 0; p < position.size(); ++p)
    if (label[p]) {
      sum += position[p].cast<double>();
      ++count;
    }
  if (count == 0) return 0;
  const Vec3f middle = (sum / static_cast<double>(count)).cast<float>();
  struct Polar {
    float radius;
    int sector;
  };
  const auto around = [&](const Vec3f& x) {
    const float a = u.dot(x - middle), b = v.dot(x - middle);
    const double turn = std::atan2(b, a) / (2 * M_PI) + 0.5;
    return Polar{std::hypot(a, b), std::min(static_cast<int>(turn * kSectors), kSectors - 1)};
  };
  std::vector<std::vector<float>> radii(kSectors);
  for (size_t p = 0; p < position.size(); ++p)
    if (label[p]) {
      const auto [radius, sector] = around(position[p]);
      radii[sector].push_back(radius);
    }
  std::vector<float> reach(kSectors);
  for (int k = 0; k < kSectors; ++k) reach[k] = quantile(std::move(radii[k]), kReach);
  const float farthest = kNear * *std::max_element(reach.begin(), reach.end());
  std::vector<int> held(kSectors, 0);
  for (size_t p = 0; p < position.size(); ++p) {
    if (label[p] || std::abs(plane.height(position[p])) > plane.tolerance) continue;
    const auto [radius, sector] = around(position[p]);
    held[sector] += radius > kClear * reach[sector] && radius < farthest;
  }
  return static_cast<float>(std::count_if(held.begin(), held.end(), [](int n) { return n >= kFew; })) / kSectors;
}

std::vector<Support> find_supports(const SupportOptions& options, const SolidScene& scene, const Vec3f& up) {
  const std::vector<Vec3f> samples = draw_in_space(scene, options.seed);
  if (samples.size() < kFewest) return {};
  const float diagonal = static_cast<float>(robust_framing(scene.cloud, up.cast<double>()).diagonal());
  const float tolerance = std::max(options.tolerance * diagonal, scene.graph.spacing),
              cell = std::max(diagonal / kCells, 1e-12f);

  std::optional<Candidate> ground, by_itself;
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
  remove_near(supports[0], thickness, left);
  for (int k = 0; k < options.most_walls && left.size() >= kFewest; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + 100 + k);
    if (plane.inliers.size() < kFewest) break;
    Candidate wall(plane, tolerance, plane.normal, samples);
    if (wall.below > wall.above.size()) wall = Candidate(plane, tolerance, -plane.normal, samples);
    remove_near(wall.support, tolerance, left);
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
