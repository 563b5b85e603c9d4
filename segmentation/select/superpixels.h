#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Connected regions of like colour and about `area` px each: [H * W] numbers from 0, without gaps.  Simple
/// non-iterative clustering (Achanta and Suesstrunk 2017): pixels join the region nearest in place and colour, from a
/// grid of seeds; a difference of `color` (Lab / 100) counts like the distance of two seeds.
std::vector<uint16_t> superpixels(int width, int height, std::span<const Vec3f> lab, float area, float color);

}  // namespace pliant
