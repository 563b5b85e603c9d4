#pragma once

#include <span>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"

namespace pliant {

/// Box around what is seen of a cloud, with axes right, forward and up: `low` and `high` are percentiles (2 and 98 %),
/// so that floaters do not count; the wider of those weighted by opacity and those weighted by visible area, the latter
/// at most a quarter of the extent farther out.
struct Framing {
  Eigen::Matrix3d axes;       ///< columns: two horizontal unit vectors and `up`
  Eigen::Vector3d low, high;  ///< corners in these axes

  Eigen::Vector3d centre() const { return axes * (0.5 * (low + high)); }
  double diagonal() const { return (high - low).norm(); }
};
Framing robust_framing(const GaussianCloud& cloud, const Eigen::Vector3d& up);

/// Opacity times the product of the two largest standard deviations, [N], these capped so that haze does not count.
std::vector<float> visible_area(const GaussianCloud& cloud);

/// How far a cloud is seen beyond the box of its centres, whose diagonal is given: two median standard deviations where
/// that box is smaller than the Gaussians themselves, as of a single one; else 0, because percentiles of many centres
/// are the box of what is seen.
double seen_beyond(const GaussianCloud& cloud, double diagonal);

struct OrbitOptions {
  int views = 24;
  int width = 800, height = 600;
  double field_of_view = 45;                  ///< degrees, of the longer side of the picture
  std::vector<double> elevations = {12, 38};  ///< degrees above the horizon; the views alternate between them
  double margin = 1.1;                        ///< distance / distance at which the robust box just fits
};

/// Views all around the robust box of `cloud`, at one distance from its centre, named orbit_000 and so on.
std::vector<Camera> orbit_cameras(const OrbitOptions& options, const GaussianCloud& cloud, const Eigen::Vector3d& up);

struct OrbitPathOptions {
  int frames = 90;
  double degrees = 360;  ///< 360 = one whole turn; less = swing by so much to either side of the first camera
};

/// Path of a clip that begins at `first` and turns around the vertical through `pivot`; it closes smoothly.
std::vector<Camera> orbit_path(const OrbitPathOptions& options, const Camera& first, const Eigen::Vector3d& pivot,
                               const Eigen::Vector3d& up);

/// Value below which the share `fraction` of the total weight lies.  Equal weights when `weight` is empty.
double weighted_percentile(std::span<const float> value, std::span<const float> weight, double fraction);

}  // namespace pliant
