#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

struct ExemplarOptions {
  int patch_radius = 3;  ///< patches of (2 r + 1)^2 pixels
  int rounds = 6;        ///< search and vote rounds at every scale
  int offsets = 12;      ///< repeated translations of the known picture that are always tried
  uint64_t seed = 0;
};

struct Offset {
  int x = 0, y = 0;
};

/// At most `count` translations under which the pixels of `probes` resemble pixels of `known` (1 = member of a mask),
/// best first: local minima of the mean squared difference where 40 % of the probes land on known pixels.
std::vector<Offset> repeated_offsets(const ImageF& picture, const ImageU8& known, const ImageU8& probes, int count);

/// Fills the pixels of `target` (1 = fill) in `picture` [H, W, 3] so that every patch around them resembles a patch of
/// the pixels of `known` (1 = may be copied); pixels in neither mask are ignored.  Space-time completion (Wexler,
/// Shechtman, Irani 2007) over PatchMatch (Barnes et al. 2009), coarse to fine; the search also tries the translations
/// under which the surroundings repeat (after He and Sun 2012), so that planks and tiles keep their period.  The
/// first guess where no translation helps is Telea's (2004).
ImageF exemplar_fill(const ExemplarOptions& options, const ImageF& picture, const ImageU8& known,
                     const ImageU8& target);

}  // namespace pliant
