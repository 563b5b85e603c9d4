#pragma once

#include <functional>

#include "gaussians/render/deform.h"
#include "gaussians/render/render_as.h"
#include "physics/mpm/adjoint/step_adjoint.h"
#include "physics/mpm/particles.h"

namespace pliant {

/// An object that is drawn in front of what stands still, in scene units.
template <class T>
struct DrawnObject {
  CloudOf<T> object, background;  ///< at rest, of one SH degree
  Binding binding;                ///< the object's Gaussians to the drivers
  std::vector<Vec3<T>> drivers;   ///< [M, 3] at rest
  double metres_per_unit = 1;
  DeformOptions deform;
  RenderOptions render;

  /// Background, then the object as the drivers carry it.
  CloudOf<T> at(const BasicSimulationState<T>& state) const;
  /// Adds to `gradient` what follows from derivatives by position [N, 3], covariance [N] and, unless empty, harmonics
  /// of `at`.
  void at_adjoint(const BasicSimulationState<T>& state, std::span<const Vec3<T>> adj_position,
                  std::span<const Mat3<T>> adj_covariance, std::span<const T> adj_sh, StateGradient<T>& gradient) const;
};

/// Colours [H, W, 3] that a camera sees of a state; `frame`: the whole picture, if it draws a part of one.
template <class T, bool kCutOffs = true>
Image<T> picture_of(const DrawnObject<T>& object, const Camera& camera, const BasicSimulationState<T>& state,
                    const std::optional<PictureFrame>& frame = {});

/// Adds to `gradient` what follows from dL/dcolours, which `adj_of` makes from the colours.
template <class T, bool kCutOffs = true>
void picture_adjoint(const DrawnObject<T>& object, const Camera& camera, const BasicSimulationState<T>& state,
                     const std::function<Image<T>(const Image<T>&)>& adj_of, StateGradient<T>& gradient,
                     const std::optional<PictureFrame>& frame = {});

extern template struct DrawnObject<float>;
extern template struct DrawnObject<double>;

}  // namespace pliant
