#pragma once

#include <filesystem>

#include "app/run/progress.h"
#include "app/segment/segment_stage.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

struct AssociatedMasks {
  MaskSet masks;
  bool ids_hold = true;  ///< every id of the masks in the folder means the same object, or none
};

/// The masks in `folder`, with ids that hold in all views: as they are, or associated as `stage` asks.  `semantic` says
/// which cameras are held out and how Gaussians are rendered; the names of masks that `segment` has made are kept.
AssociatedMasks associated_masks(const Context& context, const Scene& scene, const SegmentStage& stage,
                                 const SemanticOptions& semantic, const std::filesystem::path& folder);

}  // namespace pliant
