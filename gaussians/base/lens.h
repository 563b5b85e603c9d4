#pragma once

#include <optional>

#include "gaussians/base/camera.h"

namespace pliant {

/// Lens of OpenCV (k1, k2, p1, p2, k3, k4 of Camera::distortion) on points of the plane z = 1:
/// x' = x g + 2 p1 x y + p2 (r² + 2 x²), y' alike, g = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r²).
using Lens = std::array<double, 6>;

/// Where the lens puts the point x; `derivative` receives dx'/dx when given.
Eigen::Vector2d distort(const Lens& lens, const Eigen::Vector2d& x, Eigen::Matrix2d* derivative = nullptr);

/// The point that the lens puts to `distorted` (Newton's method).  None where the lens folds over.
std::optional<Eigen::Vector2d> undistort(const Lens& lens, const Eigen::Vector2d& distorted);

/// Image point of a point of the world through the camera's lens; none behind the camera.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& world);

/// Point of the plane z = 1 of the camera frame that is seen at image point (u, v); none where the lens folds over.
std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& uv);

}  // namespace pliant
