#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

struct PartsOptions {
  int count = 6;
  double color_weight = 0.7;  ///< of a difference of 1 in a colour channel, against the extent of what is not held
  int iterations = 30;
};

/// Parts of a body that are near together and alike in colour, by k-means (Lloyd 1982) from farthest points: [N] numbers
/// from 0 without gaps; fewer parts when there are fewer different points.  position [N, 3], color [N, 3] in 0..1.  What is
/// `held` [N] or none, not 0, never bends: it takes no parts of its own, but joins the one that it is most like.
std::vector<uint32_t> find_parts(const PartsOptions& options, std::span<const Vec3f> position, std::span<const Vec3f> color, std::span<const uint8_t> held = {});

}  // namespace pliant
