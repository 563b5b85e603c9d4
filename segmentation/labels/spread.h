#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// For every point the seen point from which it takes its label: itself if seen, else the end of the shortest chain of
/// neighbours, edges costing their squared length, so that labels flow along surfaces and do not jump gaps.
/// -1 where nothing is seen at all.
std::vector<int> nearest_seen(std::span<const Vec3f> position, const std::vector<uint8_t>& seen);

/// attribute [N, 16] of every point becomes that of its source.
void copy_attributes(const std::vector<int>& source, std::vector<float>& attribute);

}  // namespace pliant
