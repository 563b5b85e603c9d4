#pragma once

#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// Where an object rests on its support (scene units).
struct ContactRegion {
  bool found = false;                 ///< false: no plane of the support near the object's lower end
  Vec3f point = Vec3f::Zero();        ///< on the support's plane, below the object
  Vec3f normal = Vec3f::UnitZ();      ///< unit, towards the object
  float thickness = 0;                ///< root mean square distance of the plane's points from it
  float band_low = 0, band_high = 0;  ///< heights above the plane between which the object touches it
  float plane_share = 0;  ///< of those looked at, near the object's lower end; some 5 % of a cloud without any plane
  size_t touching = 0;    ///< Gaussians of the object inside the band
  float size = 0;         ///< the larger of the object's height and the radius of its base

  /// Signed height above the plane.
  float height(const Vec3f& x) const { return normal.dot(x - point); }
  bool in_band(const Vec3f& x) const { return found && height(x) <= band_high; }
};

/// A plane through points by random sample consensus (Fischler and Bolles 1981) and a principal component fit of the
/// inliers.  `up` and `max_tilt` [rad] restrict its normal when max_tilt > 0; the normal then points along `up`.
struct Plane {
  Vec3f point = Vec3f::Zero(), normal = Vec3f::UnitZ();
  float rms = 0;
  std::vector<int> inliers;  ///< indices of points within `tolerance`, ascending
};
Plane fit_plane(const std::vector<Vec3f>& points, float tolerance, uint64_t seed, const Vec3f& up = Vec3f::UnitZ(),
                float max_tilt = 0);

/// Fits the support's plane under the object from the support's Gaussians near the object's lower end and finds the
/// band of heights in which the object touches it.  Both are given by the centres of their Gaussians.  `up` is a unit
/// vector.
ContactRegion contact_region(std::span<const Vec3f> object, std::span<const Vec3f> support, const Vec3f& up);

}  // namespace pliant
