#pragma once

#include <optional>

#include "segmentation/repair/exemplar.h"

namespace pliant {

struct ShiftOptions {
  int offsets = 24;  ///< translations that are tried
  float most_error =
      0.2f;  ///< largest error around the target under a translation, relative to the surroundings' variance
  float least_reached = 0.5f;  ///< share of the target
};

struct ShiftFill {
  ImageF picture;
  ImageU8 left;  ///< 1 = of the target, but no translation lands on a known pixel: unchanged in the picture
};

/// Fills the pixels of `target` where the surroundings repeat (planks, tiles, weave): each takes the pixel that the
/// best translation lands on, to a fraction of a pixel, and the difference at the target's rim is spread inwards as a
/// membrane (Perez et al. 2003).  After He and Sun 2012.  Empty when no few translations explain what is around the
/// target or they do not reach most of it.  Masks as for exemplar_fill.
std::optional<ShiftFill> shift_fill(const ShiftOptions& options, const ImageF& picture, const ImageU8& known,
                                    const ImageU8& target);

}  // namespace pliant
