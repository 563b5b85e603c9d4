#include "app/simulate/clip_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "gaussians/base/error.h"
#include "gaussians/base/orbit.h"

namespace pliant {
namespace {

struct Rectangle {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(INFINITY), high = Eigen::Vector2d::Constant(-INFINITY);
};

/// Where the box appears (px); nothing when part of it is behind the camera.
std::optional<Rectangle> projection(const Camera& camera, const Box& box) {
  Rectangle out;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d x(corner & 1 ? box.low.x() : box.high.x(), corner & 2 ? box.low.y() : box.high.y(),
                            corner & 4 ? box.low.z() : box.high.z());
    const Eigen::Vector3d in_camera = camera.cam_from_world * x;
    if (in_camera.z() < 1e-6) return std::nullopt;
    const Eigen::Vector2d u(camera.fx * in_camera.x() / in_camera.z() + camera.cx,
                            camera.fy * in_camera.y() / in_camera.z() + camera.cy);
    out.low = out.low.cwiseMin(u);
    out.high = out.high.cwiseMax(u);
  }
  return out;
}

/// Share of the picture that the object's box covers, lowered when it is off the middle or cut by the border.
double view_score(const Camera& camera, const Box& box) {
  const std::optional<Rectangle> seen_box = projection(camera, box);
  if (!seen_box) return -1;
  const auto& [low, high] = *seen_box;
  const Eigen::Vector2d size(camera.width, camera.height);
  const Eigen::Vector2d inside = (high.cwiseMin(size) - low.cwiseMax(0.0)).cwiseMax(0.0);
  const double whole = (high - low).prod(), seen = inside.prod();
  const double off_middle = ((0.5 * (low + high) - 0.5 * size).array() / size.array()).matrix().norm();
  return seen / size.prod() * (seen / std::max(whole, 1e-9)) * (seen / std::max(whole, 1e-9)) *
         (1 - std::min(off_middle, 1.0));
}

/// The camera turned towards the object, with a longer lens if the object's box then covers less than `share` of the
/// picture's height or width.
Camera closer(const Camera& camera, const Box& box, const Eigen::Vector3d& up, double share) {
  Camera out = look_at(camera.centre(), box.centre().cast<double>(), up, camera.width, camera.height, camera.fx);
  out.name = camera.name;
  const std::optional<Rectangle> seen = projection(out, box);
  if (!seen) return camera;
  constexpr double kLeastExtent = 1e-6;
  const Eigen::Vector2d extent = (seen->high - seen->low).cwiseQuotient(Eigen::Vector2d(camera.width, camera.height));
  const double zoom = std::max(1.0, share / std::max(extent.maxCoeff(), kLeastExtent));
  out.fx *= zoom;
  out.fy *= zoom;
  return out;
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
  if (const double reach = seen_beyond(cloud, box.size().norm()); reach > 0) {
    box.low.array() -= static_cast<float>(reach);
    box.high.array() += static_cast<float>(reach);
  }
  return box;
}

std::string wanted_camera(const Scene& scene, const std::string& name) {
  return !name.empty() ? name : scene.settings.video ? scene.settings.video->camera : "";
}

const Camera& given_camera(const std::vector<Camera>& cameras, const std::string& name) {
  CHECK(!cameras.empty());
  for (const Camera& camera : cameras)
    if (camera.name == name) return camera;
  throw usage_error(
      "--camera", name, "is not a camera of this scene",
      fmt::format("{} cameras, from '{}' to '{}'", cameras.size(), cameras.front().name, cameras.back().name));
}

Camera clip_camera(const Scene& scene, const std::string& name, const Box& object) {
  CHECK(!scene.cameras.empty());
  const std::string wanted = wanted_camera(scene, name);
  if (!wanted.empty()) return given_camera(scene.cameras, wanted);
  const Camera& best = *std::max_element(
      scene.cameras.begin(), scene.cameras.end(),
      [&](const Camera& a, const Camera& b) { return view_score(a, object) < view_score(b, object); });
  // An orbit frames the whole scene, which may be much larger than the object.
  constexpr double kShare = 0.6;
  return scene.cameras_are_orbit ? closer(best, object, scene.up, kShare) : best;
}

}  // namespace pliant
