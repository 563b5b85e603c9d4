#pragma once

#include <span>
#include <vector>

#include "physics/body/surfels.h"
#include "physics/loads/signed_distance_grid.h"

namespace pliant {

struct SceneDistanceOptions {
  Box box;                        ///< part of space that gets a grid, in the surfels' unit
  double spacing = 0;             ///< of its nodes; 0 = longest side of the box / 64
  double truncation = 6;          ///< nodes; distances are cut off beyond this many
  int neighbours = 12;            ///< surfels whose planes are averaged
  std::vector<Vec3f> viewpoints;  ///< places in the open, such as the cameras': a surfel's normal is turned to the side
                                  ///< on which more of them lie; empty = normals stay
  double hole_radius = 0;  ///< holes in the surface up to this radius are closed; 0 = 3 times the surfels' spacing
};

struct SceneDistanceSummary {
  int surfels = 0, floaters = 0;  ///< used; left out because few others lie near
};

struct SceneDistanceResult {
  SignedDistanceGrid grid;  ///< empty value when no surfel lies near the box
  SceneDistanceSummary summary;
};

/// Signed distance of what the surfels bound, negative on the side away from their normals: the mean of the nearest
/// surfels' planes, weighted by area and a Gaussian of their distance (implicit moving least squares; Kolluri 2008).
/// What lies beside the end of an open surface is empty.  Surfels marked in `excluded` (those of the moving object), if
/// given, and floaters are left out.  Throws Error{kUsage} for an empty box or a grid of more than 2^27 nodes.
SceneDistanceResult make_scene_distance(const SceneDistanceOptions& options, std::span<const Surfel> surfels,
                                        std::span<const uint8_t> excluded = {});

/// The same grid in another unit of length.
SignedDistanceGrid scaled(SignedDistanceGrid grid, double factor);

}  // namespace pliant
