#include "fitting/objective/body_points.h"

#include "gaussians/render/bind.h"

namespace pliant {

template <class T>
BodyPoints<T>::BodyPoints(std::span<const Vec3f> points, std::span<const Vec3f> drivers, double metres_per_unit,
                          float max_reach)
    : metres_per_unit_(metres_per_unit) {
  BindOptions options;
  options.max_reach = max_reach;
  binding_ = pliant::bind(options, points, drivers);
  rest_.resize(points.size());
  for (size_t k = 0; k < points.size(); ++k) rest_.position[k] = points[k].template cast<T>();
  for (const Vec3f& x : drivers) drivers_.push_back(x.template cast<T>());
}

template <class T>
std::vector<Vec3<T>> BodyPoints<T>::drivers_now(const BasicSimulationState<T>& state) const {
  std::vector<Vec3<T>> now(state.size());
  for (size_t i = 0; i < now.size(); ++i) now[i] = state.x[i] / T(metres_per_unit_);
  return now;
}

template <class T>
std::vector<Vec3<T>> BodyPoints<T>::positions(const BasicSimulationState<T>& state) const {
  DeformOptions options;
  options.stretch = false;
  CloudOf<T> now;
  deform_as<T>(options, rest_, binding_, drivers_, drivers_now(state), state.F, now);
  return now.position;
}

template <class T>
void BodyPoints<T>::positions_adjoint(const BasicSimulationState<T>& state, std::span<const Vec3<T>> adj_positions,
                                      StateGradient<T>& gradient) const {
  DeformOptions options;
  options.stretch = false;
  const std::vector<Mat3<T>> no_covariance(rest_.size(), Mat3<T>::Zero());
  const DeformGradientOf<T> by = deform_adjoint<T>(options, rest_, binding_, drivers_, drivers_now(state), state.F,
                                                   adj_positions, no_covariance, {});
  for (size_t i = 0; i < state.size(); ++i) {
    gradient.x[i] += by.drivers_now[i] / T(metres_per_unit_);
    gradient.F[i] += by.F[i];
  }
}

template <class T>
Eigen::Matrix<T, 2, 1> project_point(const Camera& camera, const Vec3<T>& X) {
  const Vec3<T> c = camera.cam_from_world.linear().cast<T>() * X + camera.cam_from_world.translation().cast<T>();
  return {T(camera.fx) * c.x() / c.z() + T(camera.cx), T(camera.fy) * c.y() / c.z() + T(camera.cy)};
}

template <class T>
Vec3<T> project_point_adjoint(const Camera& camera, const Vec3<T>& X, const Eigen::Matrix<T, 2, 1>& adj_pixel) {
  const Mat3<T> R = camera.cam_from_world.linear().cast<T>();
  const Vec3<T> c = R * X + camera.cam_from_world.translation().cast<T>();
  const T a = T(camera.fx) * adj_pixel.x() / c.z(), b = T(camera.fy) * adj_pixel.y() / c.z();
  return R.transpose() * Vec3<T>(a, b, -(a * c.x() + b * c.y()) / c.z());
}

#define PLIANT_INSTANTIATE(T)                                                      \
  template class BodyPoints<T>;                                                    \
  template Eigen::Matrix<T, 2, 1> project_point<T>(const Camera&, const Vec3<T>&); \
  template Vec3<T> project_point_adjoint<T>(const Camera&, const Vec3<T>&, const Eigen::Matrix<T, 2, 1>&);
PLIANT_INSTANTIATE(float)
PLIANT_INSTANTIATE(double)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
