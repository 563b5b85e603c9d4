#pragma once

#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Which driving particles move a Gaussian: up to kCount of them with weights that sum to 1.
/// A Gaussian whose first driver is -1 does not move.
struct Binding {
  static constexpr int kCount = 8;
  std::vector<int> driver;    ///< [N, kCount], -1 = unused
  std::vector<float> weight;  ///< [N, kCount]

  size_t size() const { return driver.size() / kCount; }
};

}  // namespace pliant
