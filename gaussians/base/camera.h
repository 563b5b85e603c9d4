#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <string>

namespace pliant {

/// Pinhole camera.  Camera frame: x right, y down, z forward.  u = fx x/z + cx, v = fy y/z + cy, where pixel (i, j)
/// has its centre at (i + 0.5, j + 0.5).
struct Camera {
  std::string name;   ///< stem of the photo, or of the path frame
  std::string photo;  ///< file of the photo; empty when there is none
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  /// Lens of the photo: k1, k2, p1, p2, k3, k4 of OpenCV.  Files keep it; the renderer draws the pinhole.
  std::array<double, 6> distortion = {};
  Eigen::Isometry3d cam_from_world = Eigen::Isometry3d::Identity();

  /// Camera centre in the world.
  Eigen::Vector3d centre() const { return -(cam_from_world.linear().transpose() * cam_from_world.translation()); }
  /// Unit viewing direction in the world.
  Eigen::Vector3d forward() const { return cam_from_world.linear().row(2).transpose(); }
  /// Unit direction in the world of the ray through image point (u, v).
  Eigen::Vector3d ray(double u, double v) const {
    return (cam_from_world.linear().transpose() * Eigen::Vector3d((u - cx) / fx, (v - cy) / fy, 1.0)).normalized();
  }
  /// The same view with image size and intrinsics multiplied by `scale`.
  Camera scaled(double scale) const {
    return resized(std::max(1, static_cast<int>(width * scale + 0.5)),
                   std::max(1, static_cast<int>(height * scale + 0.5)));
  }
  /// The same view in a picture of another size.
  Camera resized(int new_width, int new_height) const {
    Camera c = *this;
    c.width = new_width;
    c.height = new_height;
    const double sx = static_cast<double>(c.width) / width, sy = static_cast<double>(c.height) / height;
    c.fx *= sx;
    c.cx *= sx;
    c.fy *= sy;
    c.cy *= sy;
    return c;
  }
  /// The same view in a picture of another size and shape: square pixels stay square, nothing that is seen is cut.
  Camera framed(int new_width, int new_height) const {
    const double scale = std::min(static_cast<double>(new_width) / width, static_cast<double>(new_height) / height);
    Camera c = *this;
    c.fx *= scale;
    c.fy *= scale;
    c.cx = 0.5 * new_width + scale * (cx - 0.5 * width);
    c.cy = 0.5 * new_height + scale * (cy - 0.5 * height);
    c.width = new_width;
    c.height = new_height;
    return c;
  }
};

/// Camera at `eye` that looks at `target`, `up` pointing up in the picture.
Camera look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up, int width,
               int height, double focal);

}  // namespace pliant
