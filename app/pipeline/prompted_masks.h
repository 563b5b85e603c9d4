#pragma once

#include "app/pipeline/stages.h"
#include "segmentation/lift/gesture_prompts.h"
#include "segmentation/lift/mask_set.h"

namespace pliant {

/// Cameras in whose pictures something was marked, ascending.
std::vector<int> marked_cameras(const Gesture& gesture);

/// What a given segmenter makes of the gestures in the photos: for every marked camera an id mask, 1 = object, 2 =
/// rest. Writes prompted/<camera>.jpg to look at.  Throws Error{kUsage} when a photo has nothing but background marks,
/// or the segmenter sees nothing there.
MaskSet prompted_masks(const Context& context, const RunDirectory& run, const Scene& scene, const Gesture& gesture,
                       const ModelChoice& models);

}  // namespace pliant
