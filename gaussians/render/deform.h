#pragma once

#include <span>

#include "gaussians/base/binding.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

struct BindOptions {
  int neighbours = 8;         ///< drivers per Gaussian, at most Binding::kCount
  float spacing = 0;          ///< mean distance of neighbouring drivers; 0 = measured
  float max_reach = 3.0f;     ///< a Gaussian farther than this many spacings from every driver does not move
};

/// Chooses the drivers of every Gaussian at rest: nearest ones that are connected to the nearest without crossing a
/// gap wider than ~2 spacings, with smooth distance weights that sum to 1.  Call it as pliant::bind: std::vector
/// arguments make a bare `bind` ambiguous with the standard library's.
Binding bind(const BindOptions& options, std::span<const Vec3f> gaussians, std::span<const Vec3f> drivers);

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

}  // namespace pliant
