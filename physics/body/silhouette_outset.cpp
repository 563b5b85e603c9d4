#include "physics/body/silhouette_outset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "gaussians/base/portable.h"
#include "physics/body/surfels.h"
#include "physics/body/winding_number.h"

namespace pliant {
namespace {

constexpr size_t kViews = 12, kFewest = 50;
constexpr float kEdgeOn = 0.2f;            // cosine between normal and line of sight
constexpr float kBeyond = 6, kBefore = 4;  // px along the normal that are searched
constexpr float kMost = 3;                 // px, the largest outset
constexpr int kHalvings = 5;
constexpr float kStep = 0.25f, kVoid = 0.1f;  // px; opacity beyond a silhouette

/// Opacity between pixel centres; none where the picture ends.
std::optional<float> opacity_at(const ImageF& alpha, const Eigen::Vector2d& pixel) {
  const double x = pixel.x() - 0.5, y = pixel.y() - 0.5;
  if (!(x >= 0 && y >= 0 && x < alpha.width - 1 && y < alpha.height - 1)) return std::nullopt;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float a = static_cast<float>(x - i), b = static_cast<float>(y - j);
  return (1 - b) * ((1 - a) * alpha(i, j) + a * alpha(i + 1, j)) +
         b * ((1 - a) * alpha(i, j + 1) + a * alpha(i + 1, j + 1));
}

/// Distance in pixels from `from` along unit `along` to where opacity falls through 1/2 into the void.
std::optional<float> distance_to_silhouette(const ImageF& alpha, const Eigen::Vector2d& from,
                                            const Eigen::Vector2d& along) {
  std::optional<float> outside = opacity_at(alpha, from + kBeyond * along);
  if (!outside || *outside > kVoid) return std::nullopt;
  for (float t = kBeyond - kStep; t >= -kBefore; t -= kStep) {
    const std::optional<float> here = opacity_at(alpha, from + t * along);
    if (!here) return std::nullopt;
    if (*here >= 0.5f) return t + kStep * (*here - 0.5f) / std::max(*here - *outside, 1e-6f);
    outside = here;
  }
  return std::nullopt;
}

/// A point of a silhouette in the void's edge, as points along its line of sight near the Gaussians that make it.
struct RimPoint {
  std::array<Vec3f, 7> sight;
  float pixel;  // its size there, scene units
};

std::vector<RimPoint> rim_points(const std::vector<Surfel>& surfels, const ImageF& alpha, const Camera& camera) {
  std::vector<RimPoint> rim;
  const Vec3d eye = camera.centre();
  for (const Surfel& s : surfels) {
    const Vec3d x = s.position.cast<double>(), to_eye = eye - x;
    const double depth = (camera.cam_from_world * x).z();
    if (!s.one_sided() || depth <= 0 || std::abs(s.normal.cast<double>().dot(to_eye.normalized())) > kEdgeOn) continue;
    const auto pixel_of = [&](const Vec3d& point) {
      const Vec3d p = camera.cam_from_world * point;
      return Eigen::Vector2d(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy);
    };
    const Eigen::Vector2d at = pixel_of(x), along = pixel_of(x + 1e-3 * depth * s.normal.cast<double>()) - at;
    if (!(along.norm() > 0)) continue;
    const auto distance = distance_to_silhouette(alpha, at, along.normalized());
    if (!distance) continue;
    const Eigen::Vector2d edge = at + *distance * along.normalized();
    const Vec3d ray = camera.ray(edge.x(), edge.y()).normalized();
    const double pixel = depth / camera.fx, middle = ray.dot(x - eye);
    RimPoint point;
    point.pixel = static_cast<float>(pixel);
    for (int k = 0; k < 7; ++k) point.sight[k] = (eye + (middle + 2 * (k - 3) * pixel) * ray).cast<float>();
    rim.push_back(point);
  }
  return rim;
}

/// Share of the silhouettes' points that the solid covers.
double covered(const GaussianCloud& object, const std::vector<RimPoint>& rim, float outset) {
  SurfelOptions options;
  options.outset = outset;
  const WindingNumber winding(make_surfels(options, object));
  std::vector<uint8_t> inside(rim.size());
  parallel_for(
      static_cast<std::ptrdiff_t>(rim.size()),
      [&](std::ptrdiff_t i) {
        inside[i] =
            std::any_of(rim[i].sight.begin(), rim[i].sight.end(), [&](const Vec3f& x) { return winding.at(x) > 0.5f; });
      },
      64);
  return std::accumulate(inside.begin(), inside.end(), 0.0) / static_cast<double>(rim.size());
}

}  // namespace

float silhouette_outset(const GaussianCloud& object, const std::vector<Camera>& cameras, const RenderOptions& options) {
  const std::vector<Surfel> surfels = make_surfels({}, object);
  std::vector<RimPoint> rim;
  const size_t views = std::min(kViews, cameras.size());
  for (size_t k = 0; k < views; ++k) {
    const Camera& camera = cameras[(2 * k + 1) * cameras.size() / (2 * views)];
    const std::vector<RimPoint> more = rim_points(surfels, render(object, camera, options).alpha, camera);
    rim.insert(rim.end(), more.begin(), more.end());
  }
  if (rim.size() < kFewest) return 0;
  std::nth_element(rim.begin(), rim.begin() + rim.size() / 2, rim.end(),
                   [](const RimPoint& a, const RimPoint& b) { return a.pixel < b.pixel; });
  // The solid covers half of the points of its silhouette; more, the larger it is.
  float low = 0, high = kMost * rim[rim.size() / 2].pixel;
  if (covered(object, rim, low) >= 0.5) return 0;
  for (int i = 0; i < kHalvings; ++i) {
    const float middle = 0.5f * (low + high);
    (covered(object, rim, middle) < 0.5 ? low : high) = middle;
  }
  return 0.5f * (low + high);
}

}  // namespace pliant
