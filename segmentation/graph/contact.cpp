#include "segmentation/graph/contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

std::vector<int> near_plane(const std::vector<Vec3f>& points, const Vec3f& point, const Vec3f& normal,
                            float tolerance) {
  std::vector<int> inliers;
  for (size_t i = 0; i < points.size(); ++i)
    if (std::abs(normal.dot(points[i] - point)) <= tolerance) inliers.push_back(static_cast<int>(i));
  return inliers;
}

}  // namespace

Plane fit_plane(const std::vector<Vec3f>& points, float tolerance, uint64_t seed, const Vec3f& up, float max_tilt) {
  Plane best;
  if (points.size() < 3) return best;
  const float min_cosine = max_tilt > 0 ? std::cos(max_tilt) : 0.0f;
  // Consensus is counted on at most kProbe points; trials are compared in order, so threads do not matter.
  constexpr int kTrials = 256;
  constexpr size_t kProbe = 4000;
  const size_t step = std::max<size_t>(1, points.size() / kProbe);
  std::vector<float> x, y, z;
  for (size_t i = 0; i < points.size(); i += step) {
    x.push_back(points[i].x());
    y.push_back(points[i].y());
    z.push_back(points[i].z());
  }
  struct Trial {
    Vec3f point, normal;
    int count = -1;
  };
  std::vector<Trial> trials(kTrials);
  parallel_for(kTrials, [&](std::ptrdiff_t t) {
    Random random(seed, t);
    const Vec3f& a = points[random.below(points.size())];
    const Vec3f& b = points[random.below(points.size())];
    const Vec3f& c = points[random.below(points.size())];
    Vec3f normal = (b - a).cross(c - a);
    if (!(normal.norm() > 1e-12f)) return;
    normal.normalize();
    if (max_tilt > 0 && std::abs(normal.dot(up)) < min_cosine) return;
    int count = 0;
    for (size_t i = 0; i < x.size(); ++i)
      count += std::abs(normal.x() * (x[i] - a.x()) + (normal.y() * (y[i] - a.y()) + normal.z() * (z[i] - a.z()))) <=
               tolerance;
    trials[t] = {a, normal, count};
  });
  const Trial& winner =
      *std::max_element(trials.begin(), trials.end(), [](const auto& a, const auto& b) { return a.count < b.count; });
  if (winner.count < 0) return best;
  best.point = winner.point;
  best.normal = winner.normal;
  for (int round = 0; round < 3; ++round) {
    const std::vector<int> inliers = near_plane(points, best.point, best.normal, tolerance);
    if (inliers.size() < 3) break;
    Vec3d mean = Vec3d::Zero();
    for (int i : inliers) mean += points[i].cast<double>();
    mean /= static_cast<double>(inliers.size());
    Mat3d covariance = Mat3d::Zero();
    for (int i : inliers) {
      const Vec3d d = points[i].cast<double>() - mean;
      covariance += d * d.transpose();
    }
    const SymmetricEigen3 axes = symmetric_eigen3(Mat3d(covariance / static_cast<double>(inliers.size())));
    const Vec3f normal = axes.vectors.col(0).cast<float>();
    if (max_tilt > 0 && std::abs(normal.dot(up)) < min_cosine) break;
    best.point = mean.cast<float>();
    best.normal = normal;
    best.rms = static_cast<float>(std::sqrt(std::max(0.0, axes.values[0])));
  }
  if (best.normal.dot(up) < 0) best.normal = -best.normal;
  best.inliers = near_plane(points, best.point, best.normal, tolerance);
  return best;
}

ContactRegion contact_region(std::span<const Vec3f> object, std::span<const Vec3f> support, const Vec3f& up) {
  ContactRegion region;
  region.normal = up;
  if (object.size() == 0) return region;

  // Lower end and base of the object along the given up.
  std::vector<float> heights(object.size());
  for (size_t i = 0; i < heights.size(); ++i) heights[i] = up.dot(object[i]);
  const float bottom = quantile(heights, 0.01), height = quantile(heights, 0.99) - bottom;
  std::vector<Vec3f> base;
  for (size_t i = 0; i < heights.size(); ++i)
    if (heights[i] <= bottom + 0.1f * height) base.push_back(object[i]);
  Vec3f centre = Vec3f::Zero();
  for (const Vec3f& x : base) centre += x / static_cast<float>(base.size());
  auto sideways = [&](const Vec3f& x) { return (x - centre - up * up.dot(x - centre)).norm(); };
  std::vector<float> radii;
  for (const Vec3f& x : base) radii.push_back(sideways(x));
  const float radius = quantile(radii, 0.98);
  region.size = std::max(height, radius);
  region.point = centre + up * (bottom - up.dot(centre));

  // Nearby Gaussians of the support; the search widens until there are enough for a plane.
  constexpr size_t kEnough = 30;
  std::vector<Vec3f> nearby;
  for (float reach = 1; reach <= 4 && nearby.size() < kEnough; reach *= 2) {
    nearby.clear();
    for (const Vec3f& x : support)
      if (sideways(x) <= radius + reach * 0.3f * region.size && std::abs(up.dot(x) - bottom) <= 0.3f * region.size)
        nearby.push_back(x);
  }
  if (nearby.size() < kEnough) return region;
  const Plane plane = fit_plane(nearby, 0.015f * region.size, 17, up, 0.6f);
  if (plane.inliers.size() < kEnough / 2) return region;
  region.found = true;
  region.normal = plane.normal;
  region.thickness = plane.rms;
  region.plane_share = static_cast<float>(plane.inliers.size()) / static_cast<float>(nearby.size());
  region.point = centre + up * (plane.normal.dot(plane.point - centre) / plane.normal.dot(up));

  // The object touches where it comes closer than a small part of its size to its own lowest height.
  for (size_t i = 0; i < heights.size(); ++i) heights[i] = region.height(object[i]);
  region.band_low = quantile(heights, 0.01);
  region.band_high = std::max(region.band_low, 0.0f) + std::max(0.04f * region.size, 3 * region.thickness);
  for (float h : heights) region.touching += h <= region.band_high;
  return region;
}

}  // namespace pliant
