#pragma once

#include <cmath>

#include "gaussians/base/portable.h"

namespace pliant {

/// Quadratic B-spline along one axis at grid coordinate x (in cells): nodes base .. base + 2 with these weights.
template <class T>
struct Spline {
  int base;
  T offset;     ///< x - base, in [0.5, 1.5)
  T weight[3];  ///< of node base + k, whose distance from x is k - offset

  HOST_DEVICE explicit Spline(T x) {
    const T floored = std::floor(x - T(0.5));
    base = static_cast<int>(floored);
    offset = x - floored;
    const T a = T(1.5) - offset, b = offset - T(1), c = offset - T(0.5);
    weight[0] = T(0.5) * a * a;
    weight[1] = T(0.75) - b * b;
    weight[2] = T(0.5) * c * c;
  }
};

}  // namespace pliant
