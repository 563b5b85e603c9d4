#pragma once

#include <filesystem>

#include "gaussians/base/image.h"

namespace pliant {

/// Masks [H, W, 1] of one object: 1 = object, 0 = rest.

/// Reads a mask as the released evaluations of LERF-Mask and NVOS do: luma above 128 of 255 is the object.  One whose
/// largest value is 1, which would be empty, is an Error{kInput}.
ImageU8 read_mask(const std::filesystem::path& file);
/// The nearest pixel of the mask at another size.
ImageU8 resized_nearest(const ImageU8& mask, int width, int height);

/// Pixels of two sets; NaN as the IoU of two empty ones, as 0 / 0 in the released evaluations.
struct MaskOverlap {
  double both = 0, either = 0, equal = 0, pixels = 0;
  double iou() const { return both / either; }
  double accuracy() const { return equal / pixels; }
};
/// Of two masks of one size, and of what lies within `band` px of their contours (boundary IoU, Cheng et al. 2021; the
/// picture's border counts as contour).
MaskOverlap mask_overlap(const ImageU8& a, const ImageU8& b);
MaskOverlap boundary_overlap(const ImageU8& a, const ImageU8& b, int band);

/// 2 % of the picture's diagonal, at least 1 px.
int boundary_band(int width, int height);

}  // namespace pliant
