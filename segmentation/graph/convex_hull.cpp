#include "segmentation/graph/convex_hull.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// At most four points of which none can be left out, and the point of their hull that is nearest to the origin.
class Corral {
 public:
  explicit Corral(const Vec3d& point) : points_{point}, weights_{1.0} {}

  Vec3d nearest() const {
    Vec3d sum = Vec3d::Zero();
    for (size_t k = 0; k < points_.size(); ++k) sum += weights_[k] * points_[k];
    return sum;
  }

  /// Takes one more point in; false when that brings nothing.
  bool add(const Vec3d& point) {
    const double before = nearest().squaredNorm();
    points_.push_back(point);
    weights_.push_back(0);
    while (true) {
      const Eigen::VectorXd flat = nearest_of_plane();
      const Eigen::Index n = flat.size();
      if ((flat.array() > 0).all()) {
        for (Eigen::Index k = 0; k < n; ++k) weights_[k] = flat[k];
        break;
      }
      // On the way there the first weight that vanishes drops its point.
      double way = 1;
      Eigen::Index first = 0;
      for (Eigen::Index k = 0; k < n; ++k)
        if (flat[k] <= 0 && weights_[k] / (weights_[k] - flat[k]) <= way) {
          way = weights_[k] / (weights_[k] - flat[k]);
          first = k;
        }
      if (!(way >= 0)) way = 0;
      for (Eigen::Index k = 0; k < n; ++k) weights_[k] += way * (flat[k] - weights_[k]);
      points_.erase(points_.begin() + first);
      weights_.erase(weights_.begin() + first);
      if (points_.size() == 1) {
        weights_[0] = 1;
        break;
      }
    }
    return nearest().squaredNorm() < before * (1 - 1e-9);
  }

 private:
  /// Weights, which add up to 1 and may be negative, of the point nearest to the origin in the plane of the points.
  Eigen::VectorXd nearest_of_plane() const {
    const auto n = static_cast<Eigen::Index>(points_.size());
    Eigen::MatrixXd system = Eigen::MatrixXd::Ones(n + 1, n + 1);
    system(n, n) = 0;
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) system(i, j) = points_[i].dot(points_[j]);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n + 1);
    right[n] = 1;
    return system.fullPivLu().solve(right).head(n);
  }

  std::vector<Vec3d> points_;
  std::vector<double> weights_;
};

}  // namespace

ConvexHull::ConvexHull(std::span<const Vec3f> points) : points_(points) {
  if (points_.empty()) return;
  Box box;
  for (const Vec3f& p : points_) box.add(p);
  size_ = box.size().norm();
  constexpr int kDirections = 128;  // a spiral of equal areas over the sphere
  for (int k = 0; k < kDirections; ++k) {
    const float z = 1 - (2 * k + 1.0f) / kDirections, r = std::sqrt(1 - z * z),
                angle = 2.399963f * static_cast<float>(k);
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
  // The point of the hull nearest to x, as a combination of at most four points (Wolfe 1976).
  constexpr int kSteps = 60;
  Corral corral(points_[0].cast<double>() - x.cast<double>());
  for (int step = 0; step < kSteps; ++step) {
    const Vec3d nearest = corral.nearest();
    if (nearest.norm() <= slack) return true;
    const Vec3f direction = nearest.cast<float>();
    size_t least = 0;
    float reach = INFINITY;
    for (size_t p = 0; p < points_.size(); ++p)
      if (const float along = direction.dot(points_[p]); along < reach) {
        reach = along;
        least = p;
      }
    const Vec3d corner = points_[least].cast<double>() - x.cast<double>();
    if (nearest.dot(corner) > slack * nearest.norm()) return false;  // the plane across `nearest` separates
    if (!corral.add(corner)) break;
  }
  return corral.nearest().norm() <= 2 * slack;
}

}  // namespace pliant
