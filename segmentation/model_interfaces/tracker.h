#pragma once

#include <cstdint>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// Where the things that are followed are in one picture.
struct TrackedFrame {
  IdImage ids;                 ///< [H, W, 1]; 0 = none of them
  std::vector<uint32_t> lost;  ///< ids that were followed and are not found here
};

/// Carries masks through an ordered sequence of pictures of one size (XMem: Cheng and Schwing 2022; DEVA: Cheng et al.
/// 2023).  Ids are the caller's, unlimited, and a thing that comes back keeps its id.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// Forgets everything and begins with `masks` (ids > 0) of `picture` [H, W, 3] sRGB in 0..1.
  virtual TrackedFrame start(const ImageF& picture, const IdImage& masks) = 0;
  /// The next picture; one of another size is an Error{kInput}.
  virtual TrackedFrame step(const ImageF& picture) = 0;
  /// Things found in the picture of the last `start` or `step`: masks that mostly overlap a followed one correct it,
  /// the others are followed from now on under ids of their own, those in `detections` unless taken.  Returns the frame
  /// as corrected.
  virtual TrackedFrame add(const IdImage& detections) = 0;
};

}  // namespace pliant
