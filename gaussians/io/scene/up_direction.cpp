#include "gaussians/io/scene/up_direction.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "gaussians/base/linear_algebra.h"
#include "gaussians/base/orbit.h"
#include "gaussians/base/random.h"
#include "gaussians/io/images/photo.h"

namespace pliant {
namespace {

constexpr int kSamples = 8000, kHypotheses = 500;
constexpr double kBand = 0.03;       // half thickness of a plane / robust diagonal of the cloud
constexpr double kLeastShare = 0.2;  // of the opacity in the plane
constexpr double kMostBelow = 0.10;  // of what is outside the plane
constexpr double kUsualWorld = 0.5;  // bonus of planes that agree with -y, the usual up of reconstructed scenes
constexpr double kUsualTilt = 40 * M_PI / 180;  // of reconstructed scenes against it
constexpr double kLeastWidth = 0.3;             // of a ground / its length
constexpr double kLeastGround = 1.5;            // area of a ground / area of what stands on it, or of its foot
constexpr double kFoot = 3;                     // height of a foot above the middle of the plane, half thicknesses
constexpr float kSole = 0.03f;                  // height of the slab on which a thing stands / its height
constexpr double kClearlyWider = 2;             // spread of one sole / spread of the other
constexpr double kLeastSpread = 0.02;           // of picture rows: mean square across their main direction (8 degrees)
constexpr double kLeastContrast = 5;            // of that to the mean square out of the plane of the rows
constexpr double kStrongMean = 0.6;             // length of the mean picture-up of cameras that agree
constexpr double kMostPitch = 70 * M_PI / 180;  // at which a strong mean is believed to be tilted
constexpr double kLeastSign = 0.2;              // cosine that tells which end of a direction is up

struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0;  // normal . x
  double share = 0;   // of the samples inside the band
  double below = 1;   // share of the samples outside the band that lie on the negative side
  double score = 0;
  double width = 0;   // share of its length
  double ground = 0;  // area inside the band / area above it, both by standard deviations
  double foot = 0;    // area inside the band / area of what is next above it: a crown is wider than its stem
};

/// Counts the samples in, above and below the plane and turns its normal so that most lie above.
void judge(const std::vector<Eigen::Vector3d>& samples, double band, Plane& plane) {
  int inside = 0, above = 0, below = 0;
  for (const Eigen::Vector3d& x : samples) {
    const double height = plane.normal.dot(x) - plane.offset;
    ++(std::abs(height) <= band ? inside : height > 0 ? above : below);
  }
  if (below > above) {
    plane.normal = -plane.normal;
    plane.offset = -plane.offset;
    std::swap(above, below);
  }
  plane.share = static_cast<double>(inside) / static_cast<double>(samples.size());
  plane.below = above > 0 ? static_cast<double>(below) / (above + below) : 1.0;
  plane.score = plane.share * (1 + kUsualWorld * std::max(0.0, -plane.normal.y()));
}

/// Whether the plane carries the rest.  One that is far from the usual vertical must also be a ground, because the flat
/// side of a thing fits a plane as well: wide, not smaller than what is above, and clearly wider than that or its foot.
bool stands_on(const Plane& plane) {
  if (plane.share < kLeastShare || plane.below > kMostBelow) return false;
  const bool usual = -plane.normal.y() >= std::cos(kUsualTilt);
  const bool wide = plane.width >= kLeastWidth && plane.ground >= 1;
  return usual || (wide && std::max(plane.ground, plane.foot) >= kLeastGround);
}

/// Square root of the determinant of the covariance of weighted points: their area by standard deviations.
double spread(const std::vector<Eigen::Vector2d>& points, const std::vector<float>& weight) {
  double total = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  for (size_t i = 0; i < points.size(); ++i) {
    const double w = weight.empty() ? 1.0 : weight[i];
    total += w;
    mean += w * points[i];
  }
  if (!(total > 0)) return 0;
  mean /= total;
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d d = points[i] - mean;
    square += (weight.empty() ? 1.0 : weight[i]) / total * d * d.transpose();
  }
  return std::sqrt(std::max(square.determinant(), 0.0));
}

/// Spread of the lowest slab of the cloud when `sign` * y points up.
double spread_of_sole(const GaussianCloud& cloud, const std::vector<float>& area, float sign) {
  std::vector<float> height(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) height[i] = sign * cloud.position[i].y();
  const double bottom = weighted_percentile(height, area, 0.01), top = weighted_percentile(height, area, 0.99);
  std::vector<Eigen::Vector2d> points;
  std::vector<float> weight;
  for (size_t i = 0; i < cloud.size(); ++i) {
    if (height[i] < bottom || height[i] > bottom + kSole * (top - bottom)) continue;
    points.emplace_back(cloud.position[i].x(), cloud.position[i].z());
    weight.push_back(area[i]);
  }
  return spread(points, weight);
}

/// Least-squares plane through the samples inside the band.
Plane refit(const std::vector<Eigen::Vector3d>& samples, double band, const Plane& plane) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::vector<const Eigen::Vector3d*> inside;
  for (const Eigen::Vector3d& x : samples) {
    if (std::abs(plane.normal.dot(x) - plane.offset) <= band) {
      inside.push_back(&x);
      mean += x;
    }
  }
  if (inside.size() < 3) return plane;
  mean /= static_cast<double>(inside.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d* x : inside) covariance += (*x - mean) * (*x - mean).transpose();
  Plane fitted;
  const SymmetricEigen3 axes = symmetric_eigen3(covariance);
  fitted.normal = axes.vectors.col(0);
  fitted.offset = fitted.normal.dot(mean);
  judge(samples, band, fitted);
  fitted.width = std::sqrt(axes.values[1] / axes.values[2]);
  std::vector<Eigen::Vector2d> in, foot, above;
  for (const Eigen::Vector3d& x : samples) {
    const double height = fitted.normal.dot(x) - fitted.offset;
    if (height < -band) continue;
    const Eigen::Vector2d place = axes.vectors.rightCols<2>().transpose() * x;
    (height <= band ? in : above).push_back(place);
    if (height > band && height <= kFoot * band) foot.push_back(place);
  }
  const double area = spread(in, {});
  fitted.ground = area / std::max(spread(above, {}), 1e-30);
  fitted.foot = area / std::max(spread(foot, {}), 1e-30);
  return fitted;
}

/// Means over the cameras, of the axes of their upright pictures in the world.
struct PictureAxes {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), forward = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square_right = Eigen::Matrix3d::Zero();  // r r^T of the directions of their rows
};

/// How the picture of a camera is to be turned; 1 where it was turned before the camera was found.
int orientation_of(const Camera& camera) {
  if (camera.photo.empty()) return 1;
  const PhotoHead head = read_photo_head(camera.photo);
  return head.width == camera.width && head.height == camera.height ? head.orientation : 1;
}

PictureAxes axes_of_pictures(const std::vector<Camera>& cameras) {
  PictureAxes mean;
  for (const Camera& camera : cameras) {
    const Eigen::Matrix3d R = camera.cam_from_world.linear();
    const Eigen::Matrix<double, 3, 2> right_down =
        R.topRows<2>().transpose() * stored_from_upright(orientation_of(camera)).cast<double>();
    mean.up -= right_down.col(1);
    mean.forward += R.row(2).transpose();
    mean.square_right += right_down.col(0) * right_down.col(0).transpose();
  }
  const double n = std::max<double>(1, static_cast<double>(cameras.size()));
  return {mean.up / n, mean.forward / n, mean.square_right / n};
}

/// Positions drawn in proportion to opacity.
std::vector<Eigen::Vector3d> draw_samples(const GaussianCloud& cloud) {
  std::vector<double> cumulative(cloud.size());
  double total = 0;
  for (size_t i = 0; i < cloud.size(); ++i) cumulative[i] = total += sigmoid(cloud.opacity_logit[i]);
  std::vector<Eigen::Vector3d> samples;
  Random random(0);
  for (int k = 0; k < kSamples; ++k) {
    const auto at = std::upper_bound(cumulative.begin(), cumulative.end(), random.uniform() * total);
    const size_t i = std::min<size_t>(at - cumulative.begin(), cloud.size() - 1);
    samples.push_back(cloud.position[i].cast<double>());
  }
  return samples;
}

}  // namespace

std::optional<Eigen::Vector3d> axis_of_name(const std::string& name) {
  const bool reversed = name.starts_with('-');
  const std::string letter = name.substr(reversed);
  for (int axis = 0; axis < 3; ++axis)
    if (letter == std::string(1, static_cast<char>('x' + axis)))
      return (reversed ? -1 : 1) * Eigen::Vector3d::Unit(axis);
  return std::nullopt;
}

std::optional<UpDirection> up_of_cameras(const std::vector<Camera>& cameras) {
  if (cameras.size() < 3) return std::nullopt;
  const std::string them = "of the " + std::to_string(cameras.size()) + " cameras";
  const PictureAxes axes = axes_of_pictures(cameras);
  std::optional<UpDirection> mean;
  if (axes.up.norm() >= 0.3) mean = UpDirection{axes.up.normalized(), "mean up " + them};
  const SymmetricEigen3 rows = symmetric_eigen3(axes.square_right);
  // Of n rows, the plane that is fitted to them takes up two.
  const auto n = static_cast<double>(cameras.size());
  const double out_of_plane = rows.values[0] * n / (n - 2);
  if (rows.values[1] < kLeastSpread || rows.values[1] < kLeastContrast * out_of_plane) return mean;
  Eigen::Vector3d up = rows.vectors.col(0);
  // Cameras that all look one way and are rolled have rows perpendicular to where they look.
  if (axes.up.norm() > kStrongMean && std::abs(up.dot(axes.up.normalized())) < std::cos(kMostPitch)) return mean;
  // Cameras that look straight down have no up in their pictures, but see what is below.
  double sign = up.dot(axes.up);
  if (std::abs(sign) < kLeastSign) sign = -up.dot(axes.forward);
  if (std::abs(sign) < kLeastSign) return mean;
  if (sign < 0) up = -up;
  return UpDirection{up, "perpendicular to the picture rows " + them};
}

UpDirection up_of_standing(const GaussianCloud& cloud) {
  const std::string otherwise = "the usual up of reconstructed scenes, because no support plane is evident";
  if (cloud.size() < 100) return {{0, -1, 0}, "-y, " + otherwise};
  const std::vector<float> area = visible_area(cloud);
  const double usual = spread_of_sole(cloud, area, -1), reversed = spread_of_sole(cloud, area, 1);
  if (reversed > kClearlyWider * usual)
    return {{0, 1, 0}, "+y, because the object stands on a wider base that way than with -y up"};
  return {{0, -1, 0}, "-y, " + otherwise};
}

bool is_near_z(const Eigen::Vector3d& up) { return up.z() > 0.77; }

UpDirection up_of_cloud(const GaussianCloud& cloud, bool z_is_up) {
  const std::optional<UpDirection> plane = up_of_support_plane(cloud);
  if (z_is_up && !(plane && is_near_z(plane->up))) return {{0, 0, 1}, "+z, as the file declares"};
  return plane ? *plane : up_of_standing(cloud);
}

std::optional<UpDirection> up_of_support_plane(const GaussianCloud& cloud) {
  if (cloud.size() < 100) return std::nullopt;
  const double band = kBand * robust_framing(cloud, Eigen::Vector3d(0, -1, 0)).diagonal();
  const std::vector<Eigen::Vector3d> samples = draw_samples(cloud);
  Plane best;
  Random random(1);
  for (int k = 0; k < kHypotheses; ++k) {
    const Eigen::Vector3d& a = samples[random.below(samples.size())];
    const Eigen::Vector3d& b = samples[random.below(samples.size())];
    const Eigen::Vector3d& c = samples[random.below(samples.size())];
    Plane plane;
    plane.normal = (b - a).cross(c - a);
    if (plane.normal.norm() < band * band) continue;
    plane.normal.normalize();
    plane.offset = plane.normal.dot(a);
    judge(samples, band, plane);
    // A rough plane cuts into what stands on it, so the strict test comes after the fit.
    if (plane.score > best.score && plane.below <= 2 * kMostBelow) best = plane;
  }
  if (best.score == 0) return std::nullopt;
  for (int k = 0; k < 5; ++k) best = refit(samples, band, best);
  if (!stands_on(best)) return std::nullopt;
  const int percent = static_cast<int>(std::lround(100 * best.share));
  return UpDirection{best.normal,
                     "normal of the support plane, which has " + std::to_string(percent) + " % of the opacity"};
}

}  // namespace pliant
