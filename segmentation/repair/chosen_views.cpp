#include "segmentation/repair/chosen_views.h"

#include <algorithm>
#include <array>

#include "gaussians/render/render.h"

namespace pliant {

Camera scaled_down(const Camera& camera, int side) {
  return camera.scaled(std::min(1.0, static_cast<double>(side) / std::max(camera.width, camera.height)));
}

std::vector<int> cameras_with_object(const HoleOptions& options, const GaussianCloud& background,
                                     const GaussianCloud& object, const std::vector<Camera>& cameras,
                                     const RenderOptions& render_options, const std::function<void()>& under_way) {
  GaussianCloud scene = background;
  scene.append(object);
  std::vector<float> is_object(background.size(), 0.0f);
  is_object.resize(scene.size(), 1.0f);
  std::vector<int> out;
  for (size_t c = 0; c < cameras.size(); ++c) {
    if (under_way) under_way();
    const Camera small = scaled_down(cameras[c], kSmallSide);
    const ImageF weight = render(scene, small, render_options, is_object, 1).features;
    if (std::any_of(weight.data.begin(), weight.data.end(), [&](float w) { return w >= options.min_object; }))
      out.push_back(static_cast<int>(c));
  }
  return out;
}

std::vector<int> choose_evenly(const std::vector<Camera>& cameras, std::vector<int> candidates, int most) {
  auto key = [&](int i) {
    const Eigen::Isometry3d& m = cameras[i].cam_from_world;
    const Vec3d eye = cameras[i].centre();
    return std::array<double, 6>{eye.x(), eye.y(), eye.z(), m(2, 0), m(2, 1), m(2, 2)};
  };
  std::stable_sort(candidates.begin(), candidates.end(), [&](int a, int b) { return key(a) < key(b); });
  const int n = std::min<int>(most, static_cast<int>(candidates.size()));
  std::vector<int> out(n);
  for (int i = 0; i < n; ++i) out[i] = candidates[static_cast<size_t>(i) * candidates.size() / n];
  return out;
}

}  // namespace pliant
