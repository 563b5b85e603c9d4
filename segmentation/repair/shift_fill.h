#pragma once

#include <optional>

#include "segmentation/repair/exemplar.h"

namespace pliant {

struct ShiftOptions {
  int offsets = 8;          ///< translations that are tried
  float most_error = 0.2f;  ///< largest error around the target under a translation, relative to the surroundings' variance
};

/// Fills the pixels of `target` where the surroundings repeat (planks, tiles, weave): each takes the pixel that the best
/// translation lands on, to a fraction of a pixel, and the difference at the target's rim is spread inwards as a
/// membrane (Perez et al. 2003).  After He and Sun 2012.  Empty when no few translations explain what is around the
/// target or do not reach all of it.  Masks as for exemplar_fill.
std::optional<ImageF> shift_fill(const ShiftOptions& options, const ImageF& picture, const ImageU8& known, const ImageU8& target);

}  // namespace pliant
