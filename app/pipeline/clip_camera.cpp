#include "app/pipeline/clip_camera.h"

#include <fmt/format.h>

#include <algorithm>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Share of the picture that the object's box covers, lowered when it is off the middle or cut by the border.
double view_score(const Camera& camera, const Box& box) {
  Eigen::Vector2d low(INFINITY, INFINITY), high(-INFINITY, -INFINITY);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d x(corner & 1 ? box.low.x() : box.high.x(), corner & 2 ? box.low.y() : box.high.y(),
                            corner & 4 ? box.low.z() : box.high.z());
    const Eigen::Vector3d in_camera = camera.cam_from_world * x;
    if (in_camera.z() < 1e-6) return -1;
    const Eigen::Vector2d u(camera.fx * in_camera.x() / in_camera.z() + camera.cx,
                            camera.fy * in_camera.y() / in_camera.z() + camera.cy);
    low = low.cwiseMin(u), high = high.cwiseMax(u);
  }
  const Eigen::Vector2d size(camera.width, camera.height);
  const Eigen::Vector2d inside = (high.cwiseMin(size) - low.cwiseMax(0.0)).cwiseMax(0.0);
  const double whole = (high - low).prod(), seen = inside.prod();
  const double off_middle = ((0.5 * (low + high) - 0.5 * size).array() / size.array()).matrix().norm();
  return seen / size.prod() * (seen / std::max(whole, 1e-9)) * (seen / std::max(whole, 1e-9)) * (1 - std::min(off_middle, 1.0));
}

}  // namespace

Box robust_bounds(const GaussianCloud& cloud) {
  Box box;
  std::vector<float> values(cloud.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < cloud.size(); ++i) values[i] = cloud.position[i][axis];
    std::sort(values.begin(), values.end());
    box.low[axis] = values[static_cast<size_t>(0.02 * (values.size() - 1))];
    box.high[axis] = values[static_cast<size_t>(0.98 * (values.size() - 1))];
  }
  return box;
}

Camera clip_camera(const Scene& scene, const std::string& name, const Box& object) {
  CHECK(!scene.cameras.empty());
  const std::string wanted = !name.empty() ? name : scene.settings.video ? scene.settings.video->camera : "";
  if (!wanted.empty()) {
    for (const Camera& camera : scene.cameras)
      if (camera.name == wanted) return camera;
    throw usage_error("--camera", wanted, "is not a camera of this scene",
                      fmt::format("{} cameras, from '{}' to '{}'", scene.cameras.size(), scene.cameras.front().name,
                                  scene.cameras.back().name));
  }
  return *std::max_element(scene.cameras.begin(), scene.cameras.end(), [&](const Camera& a, const Camera& b) {
    return view_score(a, object) < view_score(b, object);
  });
}

}  // namespace pliant
