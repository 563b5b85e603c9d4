#include "physics/body/scene_distance.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr int kCompany = 4;          // surfels that one which is no floater has within
constexpr double kCompanyReach = 4;  // times the median spacing
constexpr double kHoleSpacings = 3;

struct Cloud {
  std::vector<Surfel> surfel;
  std::vector<Vec3f> position;
};

/// Median distance to the nearest other surfel; those with little company go.
double remove_floaters(Cloud& cloud, int& floaters) {
  const NearestPoints nearest(cloud.position);
  std::vector<float> first, company;
  std::vector<NearestPoints::Hit> hits;
  for (const Vec3f& x : cloud.position) {
    nearest.query(x, kCompany + 1, hits);
    first.push_back(hits.size() > 1 ? hits[1].distance : INFINITY);
    company.push_back(hits.size() > kCompany ? hits[kCompany].distance : INFINITY);
  }
  const double spacing = quantile(first, 0.5);
  Cloud kept;
  for (size_t i = 0; i < company.size(); ++i) {
    if (company[i] > kCompanyReach * spacing) continue;
    kept.surfel.push_back(cloud.surfel[i]);
    kept.position.push_back(cloud.position[i]);
  }
  floaters = static_cast<int>(cloud.position.size() - kept.position.size());
  cloud = std::move(kept);
  return spacing;
}

/// Turns normals to the side on which most viewpoints lie: that side has been seen.
void face(Cloud& cloud, const std::vector<Vec3f>& viewpoints) {
  for (Surfel& s : cloud.surfel) {
    int balance = 0;
    for (const Vec3f& eye : viewpoints) balance += (eye - s.position).dot(s.normal) > 0 ? 1 : -1;
    if (balance < 0) s.normal = -s.normal;
  }
}

/// Signed distance at x from the surfels `hits`, nearest first.
double distance_at(const Vec3d& x, const Cloud& cloud, const std::vector<NearestPoints::Hit>& hits, double spacing,
                   double hole_radius) {
  // Weights fall off from the nearest surfel on, over what separates neighbours.
  const double least = hits[0].distance, width = 2 * spacing + 0.5 * least;
  double weights = 0, plane = 0;
  Vec3d foot = Vec3d::Zero();
  for (const auto& hit : hits) {
    const Surfel& s = cloud.surfel[hit.index];
    const double excess = (static_cast<double>(hit.distance) * hit.distance - least * least) / (width * width);
    const double w = std::max(static_cast<double>(s.area), 1e-3 * spacing * spacing) * std::exp(-excess);
    weights += w;
    plane += w * (x - s.position.cast<double>()).dot(s.normal.cast<double>());
    foot += w * s.position.cast<double>();
  }
  plane /= weights;
  foot /= weights;
  // Where the surface ends, its plane goes on without matter behind it.
  const double aside = std::sqrt(std::max((x - foot).squaredNorm() - plane * plane, 0.0));
  if (plane < 0 && aside > hole_radius + 0.5 * -plane) return aside - hole_radius;
  return plane;
}

}  // namespace

SceneDistanceResult make_scene_distance(const SceneDistanceOptions& options, std::span<const Surfel> surfels,
                                        std::span<const uint8_t> excluded) {
  CHECK(excluded.empty() || excluded.size() == surfels.size());
  if (options.box.empty()) throw usage_error("scene distance", "box", "is empty", "give the space around the object");
  const Vec3d side = options.box.size().cast<double>();
  SceneDistanceResult result;
  SignedDistanceGrid& grid = result.grid;
  grid.origin = options.box.low.cast<double>();
  grid.spacing = options.spacing > 0 ? options.spacing : side.maxCoeff() / 64;
  double nodes = 1;
  for (int a = 0; a < 3; ++a) {
    const double count = std::max(2.0, std::ceil(side[a] / grid.spacing) + 1);
    nodes *= count;
    grid.size[a] = static_cast<int>(std::min(count, 1e9));
  }
  if (!(nodes <= 1 << 27))
    throw usage_error("scene distance", "spacing", "asks for " + std::to_string(nodes) + " nodes",
                      "give a larger spacing");

  Cloud cloud;
  const float margin = static_cast<float>((options.truncation + 2) * grid.spacing);
  Box reach = options.box;
  reach.low -= Vec3f::Constant(margin);
  reach.high += Vec3f::Constant(margin);
  for (size_t i = 0; i < surfels.size(); ++i) {
    if (!excluded.empty() && excluded[i]) continue;
    if (!reach.contains(surfels[i].position) || !surfels[i].normal.allFinite()) continue;
    cloud.surfel.push_back(surfels[i]);
    cloud.position.push_back(surfels[i].position);
  }
  const double spacing = cloud.position.empty() ? 0 : remove_floaters(cloud, result.summary.floaters);
  result.summary.surfels = static_cast<int>(cloud.position.size());
  if (cloud.position.empty()) return result;

  face(cloud, options.viewpoints);
  const NearestPoints nearest(cloud.position);
  const double hole = options.hole_radius > 0 ? options.hole_radius : kHoleSpacings * spacing;
  const double limit = options.truncation * grid.spacing;
  grid.value.resize(static_cast<size_t>(grid.size[0]) * grid.size[1] * grid.size[2]);
  parallel_for(static_cast<std::ptrdiff_t>(grid.size[0]) * grid.size[1], [&](std::ptrdiff_t row) {
    std::vector<NearestPoints::Hit> hits;
    const int i = static_cast<int>(row / grid.size[1]), j = static_cast<int>(row % grid.size[1]);
    for (int k = 0; k < grid.size[2]; ++k) {
      const Vec3d x = grid.position(i, j, k);
      nearest.query(x.cast<float>(), options.neighbours, hits);
      const double d = distance_at(x, cloud, hits, spacing, hole);
      grid.value[row * grid.size[2] + k] = static_cast<float>(std::clamp(d, -limit, limit));
    }
  });
  return result;
}

SignedDistanceGrid scaled(SignedDistanceGrid grid, double factor) {
  grid.origin *= factor;
  grid.spacing *= factor;
  for (float& d : grid.value) d *= static_cast<float>(factor);
  return grid;
}

}  // namespace pliant
