#pragma once

#include <vector>

#include "gaussians/base/random.h"
#include "gaussians/base/types.h"

namespace pliant {

inline Random dice(7);

inline std::vector<float> floats(size_t n, double low = -1, double high = 1) {
  std::vector<float> values(n);
  for (float& value : values) value = static_cast<float>(dice.uniform(low, high));
  return values;
}

inline std::vector<Vec3f> vectors(size_t n) {
  std::vector<Vec3f> values(n);
  for (Vec3f& value : values) value = Vec3f(dice.normal(), dice.normal(), dice.normal());
  return values;
}

inline std::vector<Mat3f> matrices(size_t n) {
  std::vector<Mat3f> values(n);
  for (Mat3f& value : values) {
    for (int k = 0; k < 9; ++k) value(k / 3, k % 3) = dice.normal();
  }
  return values;
}

}  // namespace pliant
