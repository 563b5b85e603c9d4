#pragma once

#include <string>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// A word for something in a picture.
struct Tag {
  std::string name;
  float score = 0;  ///< 0..1
};

/// Names what is in a picture (RAM: Zhang et al. 2023).
class Tagger {
 public:
  virtual ~Tagger() = default;
  /// picture [H, W, 3] sRGB in 0..1; best first.
  virtual std::vector<Tag> tag(const ImageF& picture) = 0;
};

}  // namespace pliant
