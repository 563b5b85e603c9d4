#include "segmentation/lift/convex_hull.h"

#include <algorithm>
#include <cmath>

namespace pliant {

ConvexHull::ConvexHull(std::span<const Vec3f> points) : points_(points) {
  if (points_.empty()) return;
  Box box;
  for (const Vec3f& p : points_) box.add(p);
  size_ = box.size().norm();
  for (const Vec3f& p : points_) inner_ += p / static_cast<float>(points_.size());
  constexpr int kDirections = 128;  // a spiral of equal areas over the sphere
  for (int k = 0; k < kDirections; ++k) {
    const float z = 1 - (2 * k + 1.0f) / kDirections, r = std::sqrt(1 - z * z), angle = 2.399963f * static_cast<float>(k);
    directions_.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    float reach = -INFINITY;
    for (const Vec3f& p : points_) reach = std::max(reach, directions_.back().dot(p));
    reach_.push_back(reach);
  }
}

bool ConvexHull::contains(const Vec3f& x, float tolerance) const {
  if (points_.empty()) return false;
  const float slack = tolerance * size_;
  for (size_t k = 0; k < directions_.size(); ++k)
    if (directions_[k].dot(x) > reach_[k] + slack) return false;
  constexpr int kSteps = 100;
  Vec3f nearest = inner_ - x;  // from x to a point of the hull
  for (int step = 0; step < kSteps; ++step) {
    if (nearest.norm() <= slack) return true;
    Vec3f corner = points_[0] - x;
    for (const Vec3f& p : points_)
      if (nearest.dot(p - x) < nearest.dot(corner)) corner = p - x;
    if (nearest.dot(corner) > slack * nearest.norm()) return false;  // the plane across `nearest` separates
    const Vec3f way = corner - nearest;
    const float length = way.squaredNorm();
    if (!(length > 0)) break;
    nearest += std::clamp(-nearest.dot(way) / length, 0.0f, 1.0f) * way;
  }
  return nearest.norm() <= 4 * slack;
}

}  // namespace pliant
