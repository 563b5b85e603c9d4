#pragma once

#include <span>

#include "gaussians/base/camera.h"
#include "gaussians/render/bind.h"
#include "gaussians/render/deform.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// Points that are fixed to a body: markers, or what a camera follows.  They move like Gaussians, by the rigid fit of
/// their drivers.
template <class T>
class BodyPoints {
 public:
  /// points [K, 3] and drivers [M, 3] at rest, scene units.  A point farther than `max_reach` spacings of the drivers
  /// from all of them does not move.
  BodyPoints(std::span<const Vec3f> points, std::span<const Vec3f> drivers, double metres_per_unit,
             float max_reach = BindOptions{}.max_reach);

  size_t size() const { return rest_.size(); }
  bool moves(size_t k) const { return binding_.driver[k * Binding::kCount] >= 0; }
  /// [K, 3] scene units.
  std::vector<Vec3<T>> positions(const BasicSimulationState<T>& state) const;
  /// Adds to `gradient` what follows from dL/dpositions [K, 3].
  void positions_adjoint(const BasicSimulationState<T>& state, std::span<const Vec3<T>> adj_positions,
                         StateGradient<T>& gradient) const;

 private:
  std::vector<Vec3<T>> drivers_now(const BasicSimulationState<T>& state) const;

  CloudOf<T> rest_;
  Binding binding_;
  std::vector<Vec3<T>> drivers_;
  double metres_per_unit_ = 1;
};

/// Image point of X; and dL/dX of dL/d(image point).
template <class T>
Eigen::Matrix<T, 2, 1> project_point(const Camera& camera, const Vec3<T>& X);
template <class T>
Vec3<T> project_point_adjoint(const Camera& camera, const Vec3<T>& X, const Eigen::Matrix<T, 2, 1>& adj_pixel);

}  // namespace pliant
