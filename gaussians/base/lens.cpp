#include "gaussians/base/lens.h"

#include <Eigen/LU>

namespace pliant {
namespace {

constexpr int kNewtonSteps = 30;

}  // namespace

Eigen::Vector2d distort(const Lens& lens, const Eigen::Vector2d& p, Eigen::Matrix2d* derivative) {
  const auto& [k1, k2, p1, p2, k3, k4] = lens;
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double denominator = 1 + k4 * r2;
  const double g = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / denominator;
  if (derivative) {
    const double dg = (k1 + r2 * (2 * k2 + r2 * 3 * k3) - g * k4) / denominator;
    const double mixed = 2 * (x * y * dg + p1 * x + p2 * y);
    *derivative << g + 2 * x * x * dg + 2 * p1 * y + 6 * p2 * x, mixed,  //
        mixed, g + 2 * y * y * dg + 6 * p1 * y + 2 * p2 * x;
  }
  return {x * g + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * g + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

std::optional<Eigen::Vector2d> undistort(const Lens& lens, const Eigen::Vector2d& distorted) {
  if (lens == Lens()) return distorted;
  Eigen::Vector2d x = distorted;
  Eigen::Matrix2d derivative;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Eigen::Vector2d error = distort(lens, x, &derivative) - distorted;
    if (!(derivative.determinant() > 1e-6) || !error.allFinite()) return std::nullopt;
    if (error.norm() < 1e-12) return x;
    x -= derivative.inverse() * error;
  }
  // A few units in the last place decide whether the limit above is met.
  if (!((distort(lens, x, &derivative) - distorted).norm() < 1e-9) || !(derivative.determinant() > 1e-6))
    return std::nullopt;
  return x;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& world) {
  const Eigen::Vector3d p = camera.cam_from_world * world;
  if (!(p.z() > 0)) return std::nullopt;
  const Eigen::Vector2d x = distort(camera.distortion, p.head<2>() / p.z());
  return Eigen::Vector2d(camera.fx * x.x() + camera.cx, camera.fy * x.y() + camera.cy);
}

std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& uv) {
  return undistort(camera.distortion, {(uv.x() - camera.cx) / camera.fx, (uv.y() - camera.cy) / camera.fy});
}

}  // namespace pliant
