#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Nearest-neighbour search over a fixed set of points (k-d tree; equal distances are ordered by index).
class NearestPoints {
 public:
  explicit NearestPoints(std::span<const Vec3f> points);  ///< points must outlive this object
  ~NearestPoints();
  NearestPoints(NearestPoints&&) noexcept;

  struct Hit {
    int index;
    float distance;
  };
  /// The k nearest points (fewer if there are fewer), nearest first.
  void query(const Vec3f& x, int k, std::vector<Hit>& hits) const;
  /// All points within `radius`, nearest first.
  void within(const Vec3f& x, float radius, std::vector<Hit>& hits) const;
  /// The same in no order that means anything, but the same one each time; several times as fast where there are many.
  void around(const Vec3f& x, float radius, std::vector<Hit>& hits) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

/// Indices [queries, k] of the nearest points, -1 where there are fewer than k points.
std::vector<int> k_nearest(std::span<const Vec3f> points, std::span<const Vec3f> queries, int k);

}  // namespace pliant
