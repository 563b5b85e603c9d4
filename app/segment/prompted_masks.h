#pragma once

#include "app/run/run_directory.h"
#include "app/segment/label_models.h"
#include "segmentation/labels/mask_set.h"
#include "segmentation/select/gesture_prompts.h"

namespace pliant {

/// Cameras in whose pictures something was marked, ascending.
std::vector<int> marked_cameras(const Gesture& gesture);

/// What a given segmenter makes of the gestures in the photos: for every marked camera an id mask, 1 = object, 2 =
/// rest. Writes prompted/<camera>.jpg to look at.  Throws Error{kUsage} when a photo has nothing but background marks,
/// or the segmenter sees nothing there.
MaskSet prompted_masks(const Context& context, const RunDirectory& run, const Scene& scene, const Gesture& gesture,
                       const ModelChoice& models);

}  // namespace pliant
