#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// How far two pictures of one size [H, W, 3] show the same thing at the same place.
struct PictureMatch {
  double score = 0;  ///< correlation of colours within windows 11 px across, weighted by contrast: 1 = alike up to
                     ///< brightness, 0 = unrelated
  double shift = 0;  ///< px, median length of the flow from one to the other where there is texture
};

/// Pixels where `ignored` [H, W, 1] (may be empty) is not 0 do not count.
PictureMatch match_pictures(const ImageF& a, const ImageF& b, const ImageU8& ignored = {});
/// The score alone.
double match_score(const ImageF& a, const ImageF& b, const ImageU8& ignored = {});

/// Contrast of a picture: standard deviation of colours within windows 11 px across, [H, W, 1].
ImageF local_contrast(const ImageF& picture);

}  // namespace pliant
