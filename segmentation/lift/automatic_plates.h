#pragma once

#include <vector>

#include "segmentation/lift/automatic_surface.h"

namespace pliant {

struct PlateOptions {
  float tilt = 0.3f;         ///< rad, of a plate's normal, and of its Gaussians' normals by twice that, against up
  float tolerance = 0.01f;   ///< half thickness while it is sought / the thing's size
  float least_share = 0.08f; ///< of what the views show of the thing
  float thing_share = 0.08f; ///< the same of what stands on it
  float open = 0.3f;         ///< share of the ways from free places of the plate, level and straight, that lead out of it
};

/// Finds level plates in a thing (`nodes`, ascending) that carry others, and flags in `foot` [S] the Gaussians of the
/// plate and those of things just above it: both can stand by themselves.  A plate must be open: from a table top or a
/// plinth things can be taken sideways, not from a pot with a rim.  Returns how many plates there are.
int mark_plates(const PlateOptions& options, const SolidScene& scene, const std::vector<int>& nodes, const Vec3f& up,
                std::vector<uint8_t>& foot);

}  // namespace pliant
