#pragma once

#include <array>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Signed distance sampled at origin + spacing * (i, j, k), trilinear in between; negative in the solid.
struct SignedDistanceGrid {
  Vec3d origin = Vec3d::Zero();         ///< m
  double spacing = 0;                   ///< m
  std::array<int, 3> size = {0, 0, 0};  ///< nodes along each axis, at least 2
  std::vector<float> value;             ///< [size x, size y, size z] m, z fastest

  Vec3d position(int i, int j, int k) const { return origin + spacing * Vec3d(i, j, k); }
  float& at(int i, int j, int k) { return value[(static_cast<size_t>(i) * size[1] + j) * size[2] + k]; }

  /// Whether x lies in the box of the nodes.
  bool covers(const Vec3d& x) const {
    const Vec3d high = position(size[0] - 1, size[1] - 1, size[2] - 1);
    return (x.array() >= origin.array()).all() && (x.array() <= high.array()).all();
  }
  /// Distance and its unit gradient.  Outside the box: the value at the nearest point of the box plus the way there.
  struct Sample {
    double distance;
    Vec3d normal;
  };
  Sample sample(const Vec3d& x) const;
  /// Derivative of a scalar by x from that by the normal there [1/m].
  Vec3d normal_adjoint(const Vec3d& x, const Vec3d& adj_normal) const;

 private:
  struct Cell;
  Cell cell_at(const Vec3d& x) const;
};

}  // namespace pliant
