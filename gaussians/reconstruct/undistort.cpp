#include "gaussians/reconstruct/undistort.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/lens.h"

namespace pliant {
namespace {

constexpr double kSmallestShare = 0.1;  // of the photo's width and height that the rectangle must keep

/// Rectangle of the plane z = 1 whose points all lie between the centres of the photo's border pixels.
struct Rectangle {
  double left = -INFINITY, right = INFINITY, top = -INFINITY, bottom = INFINITY;
};

Rectangle inner_rectangle(const Camera& camera) {
  Rectangle r;
  for (int j = 0; j < camera.height; ++j) {
    if (const auto x = unproject(camera, {0.5, j + 0.5})) r.left = std::max(r.left, x->x());
    if (const auto x = unproject(camera, {camera.width - 0.5, j + 0.5})) r.right = std::min(r.right, x->x());
  }
  for (int i = 0; i < camera.width; ++i) {
    if (const auto x = unproject(camera, {i + 0.5, 0.5})) r.top = std::max(r.top, x->y());
    if (const auto x = unproject(camera, {i + 0.5, camera.height - 0.5})) r.bottom = std::min(r.bottom, x->y());
  }
  return r;
}

}  // namespace

Undistortion make_undistortion(const Camera& camera) {
  const Rectangle r = inner_rectangle(camera);
  const double across = (r.right - r.left) * camera.fx, down = (r.bottom - r.top) * camera.fy;
  if (!(across > kSmallestShare * camera.width && down > kSmallestShare * camera.height) || !std::isfinite(across + down)) {
    throw input_error(camera.photo.empty() ? camera.name : camera.photo, "distortion",
                      "is so strong that no undistorted picture is left", "check k1, k2, p1, p2, k3, k4");
  }
  const double shrink = std::min({1.0, (camera.width - 1) / across, (camera.height - 1) / down});
  Undistortion result;
  Camera& pinhole = result.pinhole = camera;
  pinhole.distortion = {};
  pinhole.fx *= shrink, pinhole.fy *= shrink;
  // The centre of the first pixel lies on the corner of the rectangle, that of the last one inside it.
  pinhole.cx = 0.5 - r.left * pinhole.fx, pinhole.cy = 0.5 - r.top * pinhole.fy;
  pinhole.width = static_cast<int>(across * shrink + 1e-6) + 1;
  pinhole.height = static_cast<int>(down * shrink + 1e-6) + 1;
  result.map_x.create(pinhole.height, pinhole.width, CV_32F);
  result.map_y.create(pinhole.height, pinhole.width, CV_32F);
  for (int j = 0; j < pinhole.height; ++j) {
    for (int i = 0; i < pinhole.width; ++i) {
      const Eigen::Vector2d x((i + 0.5 - pinhole.cx) / pinhole.fx, (j + 0.5 - pinhole.cy) / pinhole.fy);
      Eigen::Matrix2d derivative;
      const Eigen::Vector2d bent = distort(camera.distortion, x, &derivative);
      double u = bent.x() * camera.fx + camera.cx - 0.5, v = bent.y() * camera.fy + camera.cy - 0.5;
      const bool inside = derivative.determinant() > 0 && u > -0.5 && v > -0.5 && u < camera.width - 0.5 &&
                          v < camera.height - 0.5;
      if (!inside) u = v = -1, result.all_inside = false;
      result.map_x.at<float>(j, i) = static_cast<float>(u);
      result.map_y.at<float>(j, i) = static_cast<float>(v);
    }
  }
  return result;
}

}  // namespace pliant
