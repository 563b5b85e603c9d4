// The solid of an object is as large as its pictures, although its Gaussians' centres lie inside of it.

#include "physics/body/silhouette_outset.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gaussians/base/random.h"
#include "physics/body/interior_fill.h"

namespace pliant {
namespace {

constexpr double kRadius = 0.1;

/// Flat discs on a sphere, evenly spread.
GaussianCloud sphere(int count) {
  GaussianCloud cloud;
  cloud.resize(count);
  const double sigma = 0.56 * std::sqrt(4 * std::numbers::pi / count) * kRadius;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z), angle = 2.39996323 * i;
    const Vec3f n(r * std::cos(angle), r * std::sin(angle), z);
    Mat3f R;
    R.col(2) = n;
    R.col(0) = n.unitOrthogonal();
    R.col(1) = n.cross(Vec3f(R.col(0)));
    cloud.position[i] = kRadius * n;
    cloud.rotation[i] = quaternion_wxyz(R);
    cloud.log_scale[i] = Vec3d(sigma, sigma, 0.2 * sigma).array().log().matrix().cast<float>();
    cloud.opacity_logit[i] = 3;
  }
  return cloud;
}

std::vector<Camera> ring(int pixels) {
  std::vector<Camera> cameras;
  for (int k = 0; k < 6; ++k) {
    const Vec3d eye(std::cos(k), std::sin(k), 0.3);
    cameras.push_back(look_at(eye, Vec3d::Zero(), Vec3d::UnitZ(), pixels, pixels, 2.5 * pixels));
  }
  return cameras;
}

/// Radius of the sphere whose picture is as large as the object's, mean over cameras.
double radius_in_pictures(const GaussianCloud& cloud, const std::vector<Camera>& cameras) {
  double sum = 0;
  for (const Camera& camera : cameras) {
    const ImageF alpha = render(cloud, camera).alpha;
    const double area =
        static_cast<double>(std::count_if(alpha.data.begin(), alpha.data.end(), [](float a) { return a >= 0.5f; }));
    sum +=
        camera.centre().norm() * std::sin(std::atan(std::sqrt(area / std::numbers::pi) / camera.fx)) / cameras.size();
  }
  return sum;
}

double filled_radius(const GaussianCloud& cloud, float outset) {
  FillOptions options;
  options.target_count = 20000;
  options.outset = outset;
  FillSummary summary;
  fill_interior(options, cloud, &summary);
  return std::cbrt(summary.volume * 3 / (4 * std::numbers::pi));
}

TEST(SilhouetteOutset, TheSolidOfASphereIsAsLargeAsItsPictures) {
  const GaussianCloud cloud = sphere(3000);
  for (const int pixels : {64, 160}) {
    const std::vector<Camera> cameras = ring(pixels);
    const double pictured = radius_in_pictures(cloud, cameras), pixel = 1 / cameras[0].fx;
    const float outset = silhouette_outset(cloud, cameras);
    EXPECT_GT(outset, 0.4 * pixel) << pixels;
    EXPECT_NEAR(filled_radius(cloud, outset), pictured, 0.2 * pixel) << pixels;
    // Without it the solid has the radius on which the centres lie.
    EXPECT_NEAR(filled_radius(cloud, 0), kRadius, 0.02 * kRadius);
  }
}

TEST(SilhouetteOutset, FinerPicturesLeaveLessRoom) {
  const GaussianCloud cloud = sphere(3000);
  EXPECT_LT(silhouette_outset(cloud, ring(256)), 0.6 * silhouette_outset(cloud, ring(64)));
}

TEST(SilhouetteOutset, IsZeroWhereNoSilhouetteIsSeen) {
  const GaussianCloud cloud = sphere(1000);
  EXPECT_EQ(silhouette_outset(cloud, {}), 0);
  std::vector<Camera> away = ring(64);
  for (Camera& camera : away) camera = look_at(camera.centre(), 2 * camera.centre(), Vec3d::UnitZ(), 64, 64, 160);
  EXPECT_EQ(silhouette_outset(cloud, away), 0);
}

}  // namespace
}  // namespace pliant
