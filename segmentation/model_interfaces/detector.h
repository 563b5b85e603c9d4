#pragma once

#include <string>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// A named rectangle [px] of a picture.
struct Detection {
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  float score = 0;  ///< 0..1
  std::string label;
};

/// Finds instances of named things (Grounding DINO: Liu et al. 2023; YOLOX: Ge et al. 2021).
class Detector {
 public:
  virtual ~Detector() = default;
  /// picture [H, W, 3] sRGB in 0..1; boxes are clipped to it, best first.  `names` are the things looked for; a
  /// detector of a closed set leaves out other things and takes an empty list as "everything it knows".  An open
  /// vocabulary wants at least one name: Error{kUsage}.
  virtual std::vector<Detection> detect(const ImageF& picture, const std::vector<std::string>& names) = 0;
  /// Names of a closed set; empty = open vocabulary.
  virtual std::vector<std::string> vocabulary() const = 0;
};

}  // namespace pliant
