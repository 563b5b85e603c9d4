#pragma once

#include "segmentation/repair/exemplar.h"
#include "segmentation/repair/surfaces.h"

namespace pliant {

/// Gaussians that continue one plane under the holes of all views at once: the plane's own Gaussians are pictured
/// straight from the front, the texels that some view sees through a hole are filled from the plane's texture, and
/// every filled texel becomes a flat disc.  One picture serves all views, so they agree.
GaussianCloud plane_patch(const Surfaces& surfaces, int plane, const std::vector<HoleView>& views,
                          const std::vector<HoleGeometry>& geometry, const Observation& observation,
                          const GaussianCloud& background, const std::vector<Camera>& cameras,
                          const ExemplarOptions& options);

/// Gaussians for what planes did not cover in one view: colour filled in the picture itself, depth from the
/// hole's surroundings (a quantile on their far side, weighted by distance), in front of anything that nobody observed.
GaussianCloud view_patch(const HoleView& view, const Camera& camera, const ExemplarOptions& options);

}  // namespace pliant
