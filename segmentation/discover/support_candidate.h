#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "gaussians/base/quantile.h"
#include "segmentation/discover/automatic_supports.h"
#include "segmentation/graph/contact.h"

namespace pliant {

constexpr size_t kFewestOfPlane = 30;  ///< samples that a plane needs

/// A plane among the samples, and what lies on it and on its sides.
struct SupportCandidate {
  Support support;
  std::vector<Vec3f> inside, above;
  size_t below = 0;

  SupportCandidate(const Plane& plane, float tolerance, const Vec3f& normal, const std::vector<Vec3f>& samples) {
    support.point = plane.point;
    support.normal = normal;
    support.tolerance = tolerance;
    for (const Vec3f& x : samples) {
      const float h = support.height(x);
      if (std::abs(h) <= tolerance)
        inside.push_back(x);
      else if (h > 0)
        above.push_back(x);
      else
        ++below;
    }
    support.share = static_cast<double>(inside.size()) / static_cast<double>(samples.size());
  }
  double share_below() const {
    return below > 0 ? static_cast<double>(below) / static_cast<double>(below + above.size()) : 0;
  }

  /// The tolerance follows the noise of the plane's points, but not below the spacing of the Gaussians.
  void settle(float spacing) {
    constexpr float kNoise = 3.5f;  // tolerance / standard deviation of a plane's points
    std::vector<float> distance;
    for (const Vec3f& x : inside) distance.push_back(std::abs(support.height(x)));
    const float deviation = 1.4826f * quantile(distance, 0.5);
    support.tolerance = std::min(support.tolerance, std::max(kNoise * deviation, spacing));
  }
};

/// Leaves points that are farther than `tolerance` from the plane.
inline void remove_near_support(const Support& support, float tolerance, std::vector<Vec3f>& points) {
  std::erase_if(points, [&](const Vec3f& x) { return std::abs(support.height(x)) <= tolerance; });
}

}  // namespace pliant
