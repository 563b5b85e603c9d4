// The planes on which one thing stands, or before which it hangs.

#include <algorithm>
#include <cmath>

#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "segmentation/discover/automatic_supports.h"
#include "segmentation/discover/support_candidate.h"
#include "segmentation/graph/contact.h"

namespace pliant {
namespace {

/// Whether two planes pass a thing at about the same height.
bool alike(const Support& a, const Support& b, const Vec3f& thing) {
  constexpr float kCosine = 0.98f;
  return a.normal.dot(b.normal) > kCosine &&
         std::abs(a.height(thing) - b.height(thing)) <= std::max(a.tolerance, b.tolerance);
}

}  // namespace

std::vector<Support> planes_behind(const SupportOptions& options, const std::vector<Vec3f>& samples, const Vec3f& thing,
                                   float diagonal, float spacing) {
  std::vector<Support> planes;
  const float tolerance = std::max(options.tolerance * diagonal, spacing);
  std::vector<Vec3f> left = samples;
  for (int k = 0; k <= options.most_walls && left.size() >= kFewestOfPlane; ++k) {
    const Plane plane = fit_plane(left, tolerance, options.seed + k);
    if (plane.inliers.size() < kFewestOfPlane) break;
    const float side = plane.normal.dot(thing - plane.point) > 0 ? 1.0f : -1.0f;
    SupportCandidate found(plane, tolerance, side * plane.normal, samples);
    remove_near_support(found.support, tolerance, left);
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
    if (height > options.clear * support.tolerance && on >= kFewestOfPlane && beyond <= options.beyond * on)
      planes.push_back(support);
  }
  return planes;
}

std::vector<Support> planes_nearby(const SupportOptions& options, const ShownGaussians& gaussians, const Vec3f& thing,
                                   float diagonal, std::vector<Support> known) {
  std::vector<std::vector<Support>> found(std::max(options.nearer, 0));  // from wide to near
  SupportOptions nearby = options;
  nearby.beyond = INFINITY;
  parallel_for(static_cast<std::ptrdiff_t>(found.size()), [&](std::ptrdiff_t k) {
    const float radius = std::ldexp(diagonal, -2 - static_cast<int>(k));
    std::vector<Vec3f> position;
    std::vector<float> shown, apart;
    for (size_t i = 0; i < gaussians.position.size(); ++i) {
      if ((gaussians.position[i] - thing).squaredNorm() > radius * radius) continue;
      position.push_back(gaussians.position[i]);
      shown.push_back(gaussians.shown[i]);
      apart.push_back(gaussians.apart[i]);
    }
    const std::vector<Vec3f> samples = draw_points(position, shown, options.seed);
    found[k] = planes_behind(nearby, samples, thing, 2 * radius, quantile(std::move(apart), 0.5));
  });
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
    float radius = 0;
    int sector = -1;
  };
  const auto around = [&](const Vec3f& x) {
    const float a = u.dot(x - middle), b = v.dot(x - middle);
    const double turn = std::atan2(b, a) / (2 * M_PI) + 0.5;
    return Polar{std::hypot(a, b), std::min(static_cast<int>(turn * kSectors), kSectors - 1)};
  };
  std::vector<Polar> polar(position.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(position.size()),
      [&](std::ptrdiff_t p) {
        if (label[p] || std::abs(plane.height(position[p])) <= plane.tolerance) polar[p] = around(position[p]);
      },
      4096);
  std::vector<std::vector<float>> radii(kSectors);
  for (size_t p = 0; p < position.size(); ++p)
    if (label[p]) radii[polar[p].sector].push_back(polar[p].radius);
  std::vector<float> reach(kSectors);
  for (int k = 0; k < kSectors; ++k) reach[k] = quantile(std::move(radii[k]), kReach);
  const float farthest = kNear * *std::max_element(reach.begin(), reach.end());
  std::vector<int> held(kSectors, 0);
  for (size_t p = 0; p < position.size(); ++p) {
    const auto [radius, sector] = polar[p];
    if (label[p] || sector < 0) continue;
    held[sector] += radius > kClear * reach[sector] && radius < farthest;
  }
  return static_cast<float>(std::count_if(held.begin(), held.end(), [](int n) { return n >= kFew; })) / kSectors;
}

}  // namespace pliant
