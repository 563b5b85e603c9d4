#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "gaussians/base/binding.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

struct DeformOptions {
  bool stretch = true;             ///< covariance follows F as well: Sigma <- F Sigma F^T
  bool mean_displacement = false;  ///< positions move by the mean displacement, as PhysDreamer's released code does
};

/// The cloud carried by its drivers.  Rigid fit of each Gaussian's drivers: H = sum w (x - c)(x0 - c0)^T
/// + eps dx^2 sum w F with R its polar factor; position R (X - c0) + c, rotation R, SH rotated with R.
/// drivers_rest, drivers_now [M, 3] scene units; F [M] deformation gradients.
void deform(const DeformOptions& options, const GaussianCloud& rest, const Binding& binding,
            std::span<const Vec3f> drivers_rest, std::span<const Vec3f> drivers_now, std::span<const Mat3f> F,
            GaussianCloud& out);

/// `deform` in the scalar T, float or double.
template <class T>
void deform_as(const DeformOptions& options, const CloudOf<T>& rest, const Binding& binding,
               std::type_identity_t<std::span<const Vec3<T>>> drivers_rest,
               std::type_identity_t<std::span<const Vec3<T>>> drivers_now,
               std::type_identity_t<std::span<const Mat3<T>>> F, CloudOf<T>& out);

/// Derivatives with respect to what moves a cloud.
template <class T>
struct DeformGradientOf {
  std::vector<Vec3<T>> drivers_now;  ///< [M, 3]
  std::vector<Mat3<T>> F;            ///< [M]
};
using DeformGradient = DeformGradientOf<float>;

/// Reverse of `deform`, from derivatives with respect to the deformed position [N, 3], covariance [N] and spherical
/// harmonics (laid out as rest.sh, or empty).  Covariance stands for rotation and log_scale, on which pictures depend
/// only through it; entry (i, j) of adj_covariance is the derivative with respect to entry (i, j).  Gaussians that do
/// not move give nothing.  Memory: 128 bytes per Gaussian in float.  Equal bit for bit for any number of threads.
/// Compiled for float and double.
template <class T>
DeformGradientOf<T> deform_adjoint(const DeformOptions& options, const CloudOf<T>& rest, const Binding& binding,
                                   std::type_identity_t<std::span<const Vec3<T>>> drivers_rest,
                                   std::type_identity_t<std::span<const Vec3<T>>> drivers_now,
                                   std::type_identity_t<std::span<const Mat3<T>>> F,
                                   std::type_identity_t<std::span<const Vec3<T>>> adj_position,
                                   std::type_identity_t<std::span<const Mat3<T>>> adj_covariance,
                                   std::type_identity_t<std::span<const T>> adj_sh);

}  // namespace pliant
