#pragma once

#include <array>
#include <span>

#include "gaussians/base/binding.h"
#include "gaussians/base/types.h"

namespace pliant {

struct BindOptions {
  int neighbours = 8;      ///< drivers per Gaussian, at most Binding::kCount
  float spacing = 0;       ///< mean distance of neighbouring drivers; 0 = measured
  float max_reach = 3.0f;  ///< a Gaussian farther than this many spacings from every driver does not move
};

/// What is known of which drivers hang together; without links, those do that are nearer than ~2 spacings.
struct DriverLinks {
  std::span<const std::array<int, 2>> links;  ///< [L] pairs, ascending
  std::span<const int> own;                   ///< [N] driver of the part that each Gaussian shows; empty = the nearest
};

/// Chooses the drivers of every Gaussian at rest: nearest ones that are linked to its own, directly or through others
/// of those near, with smooth distance weights that sum to 1.  Call it as pliant::bind: std::vector arguments make a
/// bare `bind` ambiguous with the standard library's.
Binding bind(const BindOptions& options, std::span<const Vec3f> gaussians, std::span<const Vec3f> drivers,
             const DriverLinks& links = {});

}  // namespace pliant
