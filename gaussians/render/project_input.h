#pragma once

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/render/blend.h"
#include "gaussians/render/picture_frame.h"

namespace pliant {

/// A camera for the kernels; `frame`: the whole picture, if it draws a part of one.
template <class T>
View<T> make_view(const Camera& camera, double screen_variance = splat::kScreenVariance,
                  const std::optional<PictureFrame>& frame = {}) {
  View<T> view;
  const Eigen::Vector3d t = camera.cam_from_world.translation(), centre = camera.centre();
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) view.R[i][k] = T(camera.cam_from_world.linear()(i, k));
    view.t[i] = T(t[i]);
    view.centre[i] = T(centre[i]);
  }
  view.fx = T(camera.fx);
  view.fy = T(camera.fy);
  view.cx = T(camera.cx);
  view.cy = T(camera.cy);
  // With the principal point in the middle these are -+ 1.3 tan(field of view / 2).
  const PictureFrame whole =
      frame.value_or(PictureFrame{0, 0, static_cast<double>(camera.width), static_cast<double>(camera.height)});
  const double cx = camera.cx + whole.x, extra_x = (splat::kFrustumClamp - 1) * 0.5 * whole.width;
  const double cy = camera.cy + whole.y, extra_y = (splat::kFrustumClamp - 1) * 0.5 * whole.height;
  view.low_x = T(-(cx + extra_x) / camera.fx);
  view.high_x = T((whole.width - cx + extra_x) / camera.fx);
  view.low_y = T(-(cy + extra_y) / camera.fy);
  view.high_y = T((whole.height - cy + extra_y) / camera.fy);
  view.width = camera.width;
  view.height = camera.height;
  view.blur = T(screen_variance);
  return view;
}

/// A cloud for the kernels, which read its vectors as rows of numbers.
template <class T>
CloudInput<T> cloud_input(const CloudOf<T>& cloud) {
  static_assert(sizeof(Vec3<T>) == 3 * sizeof(T) && sizeof(Eigen::Matrix<T, 4, 1>) == 4 * sizeof(T));
  const auto numbers = [](const auto& rows) { return reinterpret_cast<const T*>(rows.data()); };
  return {numbers(cloud.position),    numbers(cloud.rotation), numbers(cloud.log_scale),
          cloud.opacity_logit.data(), cloud.sh.data(),         cloud.sh_degree};
}

/// Where the kernels add derivatives with respect to a cloud, and, unless empty, to the covariances.
template <class T>
CloudGradient<T> cloud_gradient(CloudOf<T>& cloud, std::vector<Mat3<T>>& covariance) {
  static_assert(sizeof(Mat3<T>) == 9 * sizeof(T));
  const auto numbers = [](auto& rows) { return reinterpret_cast<T*>(rows.data()); };
  return {numbers(cloud.position),    numbers(cloud.rotation), numbers(cloud.log_scale),
          cloud.opacity_logit.data(), cloud.sh.data(),         covariance.empty() ? nullptr : numbers(covariance)};
}

}  // namespace pliant
