#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Place along the Morton curve of x in [0, 1)^3, 20 bits an axis.
inline uint64_t morton_key(const Vec3d& x) {
  uint64_t key = 0;
  for (int a = 0; a < 3; ++a) {
    const uint64_t cell = static_cast<uint64_t>(std::clamp(x[a], 0.0, 0.999999) * (1 << 20));
    for (int bit = 0; bit < 20; ++bit) key |= (cell >> bit & 1) << (3 * bit + a);
  }
  return key;
}

/// Points in the order of a Morton curve of twice their extent, which `shift` in [0, 0.5)^3 moves.
inline std::vector<int> morton_order(std::span<const Vec3f> points, const Vec3d& shift = Vec3d::Zero()) {
  Box box;
  for (const Vec3f& x : points) box.add(x);
  const double side = std::max(1e-30, static_cast<double>(box.size().maxCoeff())) * 2;
  std::vector<uint64_t> key(points.size());
  for (size_t i = 0; i < points.size(); ++i) key[i] = morton_key((points[i] - box.low).cast<double>() / side + shift);
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key[a] < key[b]; });
  return order;
}

}  // namespace pliant
