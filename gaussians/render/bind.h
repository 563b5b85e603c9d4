#pragma once

#include <span>

#include "gaussians/base/binding.h"
#include "gaussians/base/types.h"

namespace pliant {

struct BindOptions {
  int neighbours = 8;      ///< drivers per Gaussian, at most Binding::kCount
  float spacing = 0;       ///< mean distance of neighbouring drivers; 0 = measured
  float max_reach = 3.0f;  ///< a Gaussian farther than this many spacings from every driver does not move
};

/// Chooses the drivers of every Gaussian at rest: nearest ones that are connected to the nearest without crossing a
/// gap wider than ~2 spacings, with smooth distance weights that sum to 1.  Call it as pliant::bind: std::vector
/// arguments make a bare `bind` ambiguous with the standard library's.
Binding bind(const BindOptions& options, std::span<const Vec3f> gaussians, std::span<const Vec3f> drivers);

}  // namespace pliant
