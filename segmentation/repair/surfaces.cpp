#include "segmentation/repair/surfaces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr float kInFront = 0.98f;  // of the depth of the object: what is nearer stands in front of it

struct RingPixel {
  int pixel, hole;  ///< and the pixel of the hole nearest to it
};

/// Pixels around the hole whose depth can be trusted: opaque, no hole, nearer than `ring` to one.
std::vector<RingPixel> ring_pixels(const HoleView& view, int ring) {
  const int width = view.hole.width, height = view.hole.height;
  cv::Mat open(height, width, CV_8U), distance, label;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) open.at<uint8_t>(y, x) = !view.hole(x, y);
  cv::distanceTransform(open, distance, label, cv::DIST_L2, 5, cv::DIST_LABEL_PIXEL);
  std::vector<int> hole_of_label(view.hole.pixels() + 1, -1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (view.hole(x, y)) hole_of_label[label.at<int>(y, x)] = y * width + x;
  std::vector<RingPixel> pixels;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (distance.at<float>(y, x) >= 1.5f && distance.at<float>(y, x) <= static_cast<float>(ring) &&
          view.picture.alpha(x, y) > 0.95f)
        pixels.push_back({y * width + x, hole_of_label[label.at<int>(y, x)]});
  return pixels;
}

Vec3f world_point(const HoleView& view, const Camera& camera, int pixel) {
  const double z = view.picture.depth.data[pixel] / view.picture.alpha.data[pixel];
  const double u = pixel % camera.width + 0.5, v = pixel / camera.width + 0.5;
  return (camera.cam_from_world.inverse() * Vec3d((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z))
      .cast<float>();
}

/// Parameter of the ray eye + t * ray on the plane, infinite behind the camera.
float hit(const Plane& plane, const Vec3f& eye, const Vec3f& ray) {
  const float t = plane.normal.dot(plane.point - eye) / plane.normal.dot(ray);
  return t > 0 ? t : INFINITY;
}

/// Centres of the background's Gaussians on a plane, in and around the box of its ring points.
std::vector<int> members_near(const Plane& plane, const GaussianCloud& background, const Box& near, float tolerance) {
  const float margin = 0.5f * near.size().norm();
  std::vector<int> members;
  for (size_t p = 0; p < background.size(); ++p) {
    const Vec3f& x = background.position[p];
    if (std::abs(plane.normal.dot(x - plane.point)) > 2 * tolerance) continue;
    if ((x.array() < near.low.array() - margin).any() || (x.array() > near.high.array() + margin).any()) continue;
    members.push_back(static_cast<int>(p));
  }
  return members;
}

/// Fits the plane to the Gaussians' centres: pictured depth leans towards the viewer, as near splats cover far ones.
void settle(Plane& plane, const GaussianCloud& background, const Box& near, float tolerance) {
  std::vector<Vec3f> centres;
  for (const int p : members_near(plane, background, near, tolerance)) centres.push_back(background.position[p]);
  Plane settled = fit_plane(centres, tolerance, 31);
  if (settled.inliers.size() < 30 || std::abs(settled.normal.dot(plane.normal)) < 0.98f) return;
  if (settled.normal.dot(plane.normal) < 0) settled.normal = -settled.normal;
  plane.point = settled.point;
  plane.normal = settled.normal;
}

/// Axes and hull of a plane from the background's Gaussians on it.
void bound(Surface& surface, const GaussianCloud& background, const Box& near, float tolerance) {
  const Plane& plane = surface.plane;
  surface.u = plane.normal.unitOrthogonal();
  surface.v = (-plane.normal).cross(surface.u);
  std::vector<cv::Point2f> points, hull;
  double extent = 0;
  for (const int p : members_near(plane, background, near, tolerance)) {
    const Vec2f at = surface.coordinates(background.position[p]);
    points.emplace_back(at[0], at[1]);
    extent += std::exp(background.log_scale[p].maxCoeff());
  }
  surface.margin = points.empty() ? 0.0f : static_cast<float>(0.5 * extent / static_cast<double>(points.size()));
  if (points.size() >= 3) cv::convexHull(points, hull);
  for (const cv::Point2f& corner : hull) surface.hull.emplace_back(corner.x, corner.y);
}

}  // namespace

bool Surface::holds(const Vec3f& x) const {
  if (hull.size() < 3) return false;
  const Vec2f at = coordinates(x);
  int left = 0, right = 0;
  for (size_t i = 0; i < hull.size(); ++i) {
    const Vec2f a = hull[i], b = hull[(i + 1) % hull.size()];
    const float side = ((b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])) / (b - a).norm();
    left += side > margin;
    right += side < -margin;
  }
  return left == 0 || right == 0;
}

Surfaces find_surfaces(const std::vector<HoleView>& views, const Observation& observation,
                       const GaussianCloud& background, const std::vector<Camera>& cameras, int ring, int max_planes) {
  std::vector<Vec3f> points;
  Vec3f eye = Vec3f::Zero();  // middle of the cameras that see the hole
  size_t seen = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    if (views[v].pixels == 0) continue;
    ++seen;
    const Camera& camera = cameras[observation.view[v]];
    for (const RingPixel& at : ring_pixels(views[v], ring)) points.push_back(world_point(views[v], camera, at.pixel));
    eye += camera.centre().cast<float>();
  }
  if (seen > 0) eye /= static_cast<float>(seen);
  Surfaces surfaces;
  if (points.size() < 30) return surfaces;
  // At most kUsed points, evenly chosen; their spread sets the tolerance.
  constexpr size_t kUsed = 20000;
  const size_t step = (points.size() + kUsed - 1) / kUsed;
  std::vector<Vec3f> used;
  for (size_t i = 0; i < points.size(); i += step) used.push_back(points[i]);
  std::vector<float> distance;
  Vec3f centre = Vec3f::Zero();
  for (const Vec3f& x : used) centre += x / static_cast<float>(used.size());
  for (const Vec3f& x : used) distance.push_back((x - centre).norm());
  surfaces.tolerance = 0.02f * quantile(distance, 0.5);

  const size_t enough = std::max<size_t>(30, used.size() / 20);
  for (int k = 0; k < max_planes && used.size() >= enough; ++k) {
    Plane plane = fit_plane(used, surfaces.tolerance, 31 + k);
    if (plane.inliers.size() < enough) break;
    if (plane.normal.dot(eye - plane.point) < 0) plane.normal = -plane.normal;
    std::vector<Vec3f> rest;
    Box near;
    size_t next = 0;
    for (size_t i = 0; i < used.size(); ++i) {
      if (next < plane.inliers.size() && plane.inliers[next] == static_cast<int>(i)) {
        near.add(used[i]);
        ++next;
      } else if (std::abs(plane.normal.dot(used[i] - plane.point)) > 2 * surfaces.tolerance)
        rest.push_back(used[i]);
    }
    used = std::move(rest);
    settle(plane, background, near, surfaces.tolerance);
    Surface surface;
    surface.plane = std::move(plane);
    bound(surface, background, near, surfaces.tolerance);
    surfaces.plane.push_back(std::move(surface));
  }
  return surfaces;
}

HoleGeometry place_hole(const Surfaces& surfaces, const HoleView& view, const Observation& observation, size_t index,
                        const Camera& camera, int ring) {
  const int width = view.hole.width, height = view.hole.height;
  HoleGeometry geometry{
      std::vector<int>(view.hole.pixels(), -1), std::vector<Vec3f>(view.hole.pixels(), Vec3f::Zero()), {}};
  const int planes = static_cast<int>(surfaces.plane.size());
  if (planes == 0 || view.pixels == 0) return geometry;

  // Ring pixels of every plane in this view (the last row: of none), and the image distance of every pixel to them.
  std::vector<cv::Mat> away(planes + 1);
  std::vector<size_t> count(planes + 1, 0);
  std::vector<Vec3f> middle(planes + 1, Vec3f::Zero());
  for (cv::Mat& mask : away) mask = cv::Mat(height, width, CV_8U, cv::Scalar(1));
  size_t all = 0;
  const ImageF &object = observation.object[index], &object_depth = observation.depth[index];
  for (const auto& [pixel, hole] : ring_pixels(view, ring)) {
    const Vec3f x = world_point(view, camera, pixel);
    int best = planes;
    float nearest = 2 * surfaces.tolerance;
    for (int k = 0; k < planes; ++k) {
      const Plane& plane = surfaces.plane[k].plane;
      if (const float d = std::abs(plane.normal.dot(x - plane.point)); d < nearest) {
        nearest = d;
        best = k;
      }
    }
    const float depth = view.picture.depth.data[pixel] / view.picture.alpha.data[pixel];
    if (best == planes && depth * object.data[hole] < kInFront * object_depth.data[hole]) continue;
    ++all;
    away[best].at<uint8_t>(pixel / width, pixel % width) = 0;
    ++count[best];
    middle[best] += x;
  }
  // Depth is blended along edges and creases: thin lines of points on no plane are no surface of their own.
  cv::morphologyEx(away[planes], away[planes], cv::MORPH_CLOSE, cv::Mat::ones(5, 5, CV_8U));
  count[planes] = static_cast<size_t>(width) * height - static_cast<size_t>(cv::countNonZero(away[planes]));
  for (int k = 0; k <= planes; ++k) {
    if (count[k]) middle[k] /= static_cast<float>(count[k]);
    if (count[k] < std::max<size_t>(4, all / 50))
      count[k] = 0;
    else
      cv::distanceTransform(away[k], away[k], cv::DIST_L2, 5);
  }
  // Two planes form a corner towards the camera when each lies in front of the other.
  auto corner = [&](int a, int b) {
    const Plane &p = surfaces.plane[a].plane, &q = surfaces.plane[b].plane;
    return p.normal.dot(middle[b] - p.point) > 0 && q.normal.dot(middle[a] - q.point) > 0;
  };

  const Vec3f eye = camera.centre().cast<float>();
  std::vector<float> t(planes);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (!view.hole(x, y)) continue;
      const Vec3f ray = camera.ray(x + 0.5, y + 0.5).cast<float>();
      // The nearest surroundings among planes that the ray meets inside their hulls, and what is not flat.
      int nearest = -1;
      for (int k = 0; k <= planes; ++k) {
        if (!count[k]) continue;
        if (k < planes) t[k] = hit(surfaces.plane[k].plane, eye, ray);
        if (k < planes && !(std::isfinite(t[k]) && surfaces.plane[k].holds(eye + t[k] * ray)))
          t[k] = INFINITY;
        else if (nearest < 0 || away[k].at<float>(y, x) < away[nearest].at<float>(y, x))
          nearest = k;
      }
      const int pixel = y * width + x;
      if (nearest < 0 || nearest == planes) {
        if (view.open(x, y)) geometry.nowhere.push_back(pixel);
        continue;
      }
      int chosen = nearest;
      for (int k = 0; k < planes; ++k)
        if (count[k] && k != nearest && t[k] < t[chosen] && corner(nearest, k)) chosen = k;
      geometry.plane[pixel] = chosen;
      geometry.point[pixel] = eye + t[chosen] * ray;
    }
  return geometry;
}

}  // namespace pliant
