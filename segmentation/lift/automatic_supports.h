#pragma once

#include <vector>

#include "segmentation/lift/automatic_surface.h"

namespace pliant {

struct SupportOptions {
  float tolerance = 0.01f;     ///< half thickness of a plane while it is sought / diagonal of the scene;
  float roughest = 4;          ///< up to so many times that for the ground, which may be a lawn
  float tilt = 0.6f;           ///< rad, of the ground's normal against up
  float ground_share = 0.10f;  ///< least share of what the views show that lies on the ground,
  float below = 0.10f;         ///< most of the rest below it,
  float ground_area = 0.7f;    ///< and least area / area of what is above it
  float wall_share = 0.05f;    ///< the same for walls,
  float behind = 0.03f;        ///< most of the rest behind it,
  float wall_width = 0.5f;     ///< and least width / width of the ground in that direction
  int most_walls = 4;
  uint64_t seed = 1;
};

/// A plane that things stand on or before (scene units).
struct Support {
  bool wall = false;
  Vec3f point = Vec3f::Zero(), normal = Vec3f::UnitZ();  ///< unit, towards the things
  float tolerance = 0;  ///< height up to which its own Gaussians reach
  double share = 0;     ///< of what the views show

  float height(const Vec3f& x) const { return normal.dot(x - point); }
};

/// The ground, the lowest wide plane across `up` with next to nothing below, comes first; then walls: wide upright
/// planes with everything on one side.  Empty when there is no ground.  Planes by random sample consensus over
/// Gaussians drawn in proportion to what the views show of them.
std::vector<Support> find_supports(const SupportOptions& options, const SolidScene& scene, const Vec3f& up);

}  // namespace pliant
