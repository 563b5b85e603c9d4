#pragma once

#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Ways along a body from where it stands.
struct SupportPaths {
  std::vector<float> length;  ///< [N] of the shortest way to the support through the body
  std::vector<float> beyond;  ///< [N] share of the volume that is carried through a point: what lies behind it
};

/// Shortest paths (Dijkstra 1959) over the graph of nearest neighbours, made whole by the edges of a minimal spanning
/// tree (Prim 1957).  The support is the lowest fiftieth of the `height` [N] of the points.
SupportPaths support_paths(std::span<const Vec3f> points, std::span<const float> volume, std::span<const float> height);

}  // namespace pliant
