#include "gaussians/reconstruct/start_cloud.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/random.h"

namespace pliant {

double camera_extent(const std::vector<Camera>& cameras) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) mean += camera.centre() / cameras.size();
  double farthest = 0;
  for (const Camera& camera : cameras) farthest = std::max(farthest, (camera.centre() - mean).norm());
  return farthest > 1e-9 ? 1.1 * farthest : 1.0;
}

GaussianCloud cloud_from_points(std::span<const Vec3f> position, std::span<const Vec3f> color) {
  CHECK(position.size() == color.size());
  GaussianCloud cloud;
  cloud.resize(position.size());
  const int neighbours = 4;  // the point itself and three more
  const std::vector<int> near = k_nearest(position, position, neighbours);
  for (size_t i = 0; i < position.size(); ++i) {
    float sum = 0, count = 0;
    for (int k = 0; k < neighbours; ++k) {
      const int j = near[i * neighbours + k];
      if (j >= 0 && static_cast<size_t>(j) != i) {
        sum += (position[j] - position[i]).squaredNorm();
        ++count;
      }
    }
    cloud.position[i] = position[i];
    cloud.log_scale[i].setConstant(0.5f * std::log(std::max(1e-7f, count > 0 ? sum / count : 1.0f)));
    cloud.opacity_logit[i] = logit(0.1f);
    for (int c = 0; c < 3; ++c) cloud.sh_of(i)[c] = (color[i][c] - 0.5f) / kSh0;
  }
  return cloud;
}

GaussianCloud random_cloud(const std::vector<Camera>& cameras, size_t count, uint64_t seed) {
  CHECK(!cameras.empty());
  // The point with the smallest sum of squared distances from the viewing axes.
  Eigen::Matrix3d A = 1e-6 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - camera.forward() * camera.forward().transpose();
    A += across;
    b += across * camera.centre();
    mean += camera.centre() / cameras.size();
  }
  b += 1e-6 * mean;
  const Eigen::Vector3d centre = solve_symmetric(A, b);
  double radius = 0;
  for (const Camera& camera : cameras) {
    const double half_view = std::max(camera.width / camera.fx, camera.height / camera.fy) / 2;
    radius += (camera.centre() - centre).norm() * half_view / cameras.size();
  }
  radius = std::max(radius, 1e-3 * camera_extent(cameras));
  std::vector<Vec3f> position(count), color(count, Vec3f::Constant(0.5f));
  for (size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    Vec3d direction(random.normal(), random.normal(), random.normal());
    position[i] = (centre + radius * std::cbrt(random.uniform()) * direction.normalized()).cast<float>();
  }
  return cloud_from_points(position, color);
}

}  // namespace pliant
