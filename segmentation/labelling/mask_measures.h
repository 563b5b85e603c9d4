#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/base/image.h"
#include "segmentation/model_interfaces/promptable_segmenter.h"

namespace pliant {

/// Pixels with logits > 0.
size_t pixels_of(const ImageF& logits);

/// Smallest box around the pixels with logits > 0; empty (x1 < x0) when there is none.
MaskPrompt::Box box_of_mask(const ImageF& logits);

/// Intersection over union of the masks at two thresholds, logits > offset and logits > -offset (Kirillov et al. 2023,
/// "stability score"); 0 for an empty mask.
float stability(const ImageF& logits, float offset);

/// Intersection over union of two masks (logits > 0) of one size; 0 when both are empty.
float mask_iou(const ImageF& a, const ImageF& b);

/// Intersection over union of two boxes; 0 when both have no area.
float box_iou(const MaskPrompt::Box& a, const MaskPrompt::Box& b);

/// Negates the logits of parts of the mask with less than `least` of its pixels, and of holes with less than
/// `least_hole`, unless they hold a pixel with `given` [H * W] != 0.
void tidy_parts(const std::vector<uint8_t>& given, float least, float least_hole, ImageF& logits);

}  // namespace pliant
