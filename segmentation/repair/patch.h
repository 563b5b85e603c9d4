#pragma once

#include "segmentation/model_interfaces/inpainter.h"
#include "segmentation/repair/exemplar.h"
#include "segmentation/repair/plane_picture.h"
#include "segmentation/repair/refine.h"

namespace pliant {

/// A plane's picture and what has been decided about its target.
struct PlaneFill {
  PlanePicture picture;
  ImageF color;     ///< [H, W, 3] the picture's colour, and in `colored` texels what they were filled with
  ImageU8 colored;  ///< [H, W, 1] 1 = filled
  explicit PlaneFill(PlanePicture of);
};

/// Fills the whole target from the plane's own texture: carried over where it repeats, else pieced together.
void fill_from_texture(PlaneFill& plane, const ExemplarOptions& options);
/// A view's picture with its hole filled, and the pixels that were: the hole and a pixel around it.
struct ViewFill {
  ImageF color;
  ImageU8 mask;
};

/// Fills the target texels that a view sees in its filled pixels on plane `index` with their colour.  Returns those
/// that were filled now.
ImageU8 fill_from_view(PlaneFill& plane, int index, const ViewFill& view, const HoleGeometry& geometry,
                       const Camera& camera);

/// Flat discs for the texels of `which` (1 = wanted) that the plane does not cover yet.  One picture serves all views,
/// so they agree.
GaussianCloud plane_patch(const PlaneFill& plane, const ImageU8& which, const GaussianCloud& background);

/// By the inpainter, or with none by exemplars of the picture itself.
ViewFill fill_view(const HoleView& view, const ExemplarOptions& options, Inpainter* inpainter);

/// Gaussians for the pixels of `which`: depth from the hole's surroundings (a quantile on their far side, weighted by
/// distance), in front of anything that nobody observed.
GaussianCloud view_patch(const HoleView& view, const Camera& camera, const ImageF& filled, const ImageU8& which);

/// What a view should show: the filled planes in its hole, elsewhere `picture`, as it is now.
FilledView show_planes(const std::vector<PlaneFill>& planes, const ImageF& picture, const ImageU8& hole,
                       const HoleGeometry& geometry, const Camera& camera);

}  // namespace pliant
