#pragma once

#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Membership in the convex hull of points, which must outlive this object.
class ConvexHull {
 public:
  explicit ConvexHull(std::span<const Vec3f> points);

  /// Whether x lies in the hull or within `tolerance` of its size from it.  Supporting planes in fixed directions
  /// decide most cases; else the hull's point nearest to x is found (Wolfe 1976).
  bool contains(const Vec3f& x, float tolerance = 2e-3f) const;

 private:
  std::span<const Vec3f> points_;
  std::vector<Vec3f> directions_;
  std::vector<float> reach_;  ///< of the hull along every direction
  float size_ = 0;
};

}  // namespace pliant
