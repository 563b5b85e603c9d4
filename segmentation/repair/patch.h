#pragma once

#include "segmentation/repair/exemplar.h"
#include "segmentation/repair/plane_picture.h"

namespace pliant {

/// Gaussians that continue one plane under the holes of all views at once: the target of its picture is filled from
/// the plane's texture, and every filled texel becomes a flat disc.  One picture serves all views, so they agree.
GaussianCloud plane_patch(const PlanePicture& picture, const GaussianCloud& background, const ExemplarOptions& options);

/// Gaussians for what planes did not cover in one view: colour filled in the picture itself, depth from the
/// hole's surroundings (a quantile on their far side, weighted by distance), in front of anything that nobody observed.
GaussianCloud view_patch(const HoleView& view, const Camera& camera, const ExemplarOptions& options);

}  // namespace pliant
