#pragma once

#include <vector>

#include "segmentation/model_interfaces/detector.h"

namespace pliant {

/// Intersection over union of two boxes.
float box_iou(const Detection& a, const Detection& b);

/// Best first; of boxes with one label that overlap by more than `most` only the best stays.  Boxes of equal score keep
/// their order.
std::vector<Detection> suppress_overlaps(std::vector<Detection> boxes, float most);

/// The box cut to a picture; false when nothing of it is left.
bool clip_box(Detection& box, int width, int height);

}  // namespace pliant
