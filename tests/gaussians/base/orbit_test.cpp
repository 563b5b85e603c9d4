// Automatic orbits: everything that counts is in every picture, floaters do not count, paths close smoothly.

#include "gaussians/base/orbit.h"

#include <gtest/gtest.h>

#include <numeric>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

GaussianCloud box_with_floaters(int n, int floaters) {
  GaussianCloud cloud;
  cloud.resize(n + floaters);
  Random random(1);
  for (int i = 0; i < n + floaters; ++i) {
    for (int k = 0; k < 3; ++k) cloud.position[i][k] = static_cast<float>(random.uniform(-1, 1) * (k + 1) + 5);
    if (i >= n) cloud.position[i] *= 100;
    cloud.opacity_logit[i] = i >= n ? -4.0f : 4.0f;
  }
  return cloud;
}

TEST(Orbit, WeightedPercentileIsTheLeastValueUpToWhichTheShareLies) {
  std::vector<float> value, weight;
  for (int i = 0; i < 500; ++i) {
    Random random(3, i);
    value.push_back(static_cast<float>(random.below(100)));  // many are equal
    weight.push_back(static_cast<float>(random.below(8)));   // of which sums are exact
  }
  const double total = std::accumulate(weight.begin(), weight.end(), 0.0);
  for (const double fraction : {0.0, 0.02, 0.3, 0.5, 0.98, 1.0}) {
    const double found = weighted_percentile(value, weight, fraction);
    double below = 0, upto = 0;
    for (size_t i = 0; i < value.size(); ++i) {
      if (value[i] < found) below += weight[i];
      if (value[i] <= found) upto += weight[i];
    }
    EXPECT_GE(upto, fraction * total);
    EXPECT_TRUE(below < fraction * total || fraction == 0) << fraction;
  }
}

TEST(Orbit, WeightedPercentileOfEqualWeightsIsThePercentile) {
  std::vector<float> value;
  for (int i = 100; i > 0; --i) value.push_back(i);
  EXPECT_EQ(weighted_percentile(value, {}, 0.25), 25);
  EXPECT_EQ(weighted_percentile(value, {}, 1.0), 100);
  const std::vector<float> weight = {0, 0, 1};
  EXPECT_EQ(weighted_percentile(std::vector<float>{1, 2, 3}, weight, 0.1), 3);
}

TEST(Orbit, FramingIgnoresFloaters) {
  const GaussianCloud cloud = box_with_floaters(5000, 500);
  const Framing framing = robust_framing(cloud, {0, 0, 2});
  EXPECT_LT((framing.centre() - Eigen::Vector3d(5, 5, 5)).norm(), 0.2);
  EXPECT_NEAR(framing.high[2] - framing.low[2], 6 * 0.96, 0.3);
  EXPECT_NEAR(framing.axes.determinant(), 1, 1e-12);
}

TEST(Orbit, FramingHoldsAPlainThingOfFewLargeGaussiansAndAFineOneOfManySmall) {
  GaussianCloud cloud;
  cloud.resize(10000 + 100);
  Random random(2);
  for (size_t i = 0; i < cloud.size(); ++i) {
    const bool fine = i < 10000;
    cloud.position[i] =
        Vec3f(random.uniform(0, 1), random.uniform(0, 1), fine ? random.uniform(0, 1) : random.uniform(-0.2, 0));
    cloud.log_scale[i] = Vec3f::Constant(std::log(fine ? 0.002f : 0.03f));
    cloud.opacity_logit[i] = 4;
  }
  const Framing framing = robust_framing(cloud, {0, 0, 1});
  EXPECT_LT(framing.low[2], -0.18);
  EXPECT_GT(framing.high[2], 0.97);
  // Haze of the same total area, but far away, is followed for a quarter of the extent only.
  for (size_t i = 10000; i < cloud.size(); ++i) cloud.position[i].z() -= 5;
  EXPECT_GT(robust_framing(cloud, {0, 0, 1}).low[2], -0.3);
}

TEST(Orbit, EveryViewHoldsTheRobustBoxAndOneJustFits) {
  const GaussianCloud cloud = box_with_floaters(5000, 100);
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0.1, 0.2, 1)}) {
    OrbitOptions options;
    options.views = 12;
    options.margin = 1.0;
    const Framing framing = robust_framing(cloud, up);
    double tightest = 1e9;
    const std::vector<Camera> cameras = orbit_cameras(options, cloud, up);
    ASSERT_EQ(cameras.size(), 12u);
    for (const Camera& camera : cameras) {
      EXPECT_GT(-camera.cam_from_world.linear().row(1).dot(up), 0.5 * up.norm());  // up points up in the picture
      for (int corner = 0; corner < 8; ++corner) {
        Eigen::Vector3d x;
        for (int k = 0; k < 3; ++k) x[k] = (corner >> k) & 1 ? framing.high[k] : framing.low[k];
        const Eigen::Vector3d p = camera.cam_from_world * (framing.axes * x);
        const double u = camera.fx * p.x() / p.z() + camera.cx, v = camera.fy * p.y() / p.z() + camera.cy;
        EXPECT_GT(p.z(), 0);
        tightest = std::min({tightest, u, camera.width - u, v, camera.height - v});
      }
    }
    EXPECT_NEAR(tightest, 0, 1e-6);
  }
}

TEST(Orbit, ShowsFewLargeGaussiansWholeAndLeavesManyAsTheyAre) {
  constexpr double kSize = 0.1;
  GaussianCloud cloud;
  cloud.resize(1);
  cloud.log_scale[0] = Vec3f::Constant(std::log(kSize));
  cloud.opacity_logit[0] = 2;
  EXPECT_NEAR(seen_beyond(cloud, 0), 2 * kSize, 1e-6);
  OrbitOptions options;
  for (const Camera& camera : orbit_cameras(options, cloud, {0, 0, 1})) {
    const double distance = camera.centre().norm();
    EXPECT_GT(distance, 2 * kSize);
    EXPECT_LT(camera.fx * 2 * kSize / distance, 0.5 * camera.width);
    EXPECT_GT(camera.fx * 2 * kSize / distance, 0.1 * camera.width);
  }
  const GaussianCloud many = box_with_floaters(1000, 0);
  EXPECT_EQ(seen_beyond(many, robust_framing(many, {0, 0, 1}).diagonal()), 0);
}

TEST(OrbitPath, AFullTurnKeepsTheDistanceAndClosesWithEqualSteps) {
  const Eigen::Vector3d pivot(1, 2, 3), up(0, -1, 0);
  const Camera first = look_at({4, 1, 3}, {1.2, 2, 3}, up, 400, 300, 300);
  const std::vector<Camera> path = orbit_path({60, 360}, first, pivot, up);
  ASSERT_EQ(path.size(), 60u);
  EXPECT_TRUE(path[0].cam_from_world.isApprox(first.cam_from_world, 1e-12));
  const double step = (path[1].centre() - path[0].centre()).norm();
  for (size_t i = 0; i < path.size(); ++i) {
    EXPECT_NEAR((path[i].centre() - pivot).norm(), (first.centre() - pivot).norm(), 1e-9);
    EXPECT_NEAR((path[(i + 1) % 60].centre() - path[i].centre()).norm(), step, 1e-9);
    EXPECT_NEAR((path[i].cam_from_world * pivot - first.cam_from_world * pivot).norm(), 0, 1e-9);
  }
}

TEST(OrbitPath, ASwingStaysInsideItsAngle) {
  const Eigen::Vector3d pivot(0, 0, 0), up(0, 0, 1);
  const Camera first = look_at({0, -3, 1}, pivot, up, 400, 300, 300);
  double widest = 0;
  for (const Camera& camera : orbit_path({100, 20}, first, pivot, up)) {
    const Eigen::Vector3d c = camera.centre();
    widest = std::max(widest, std::abs(std::atan2(c.x(), -c.y())) * 180 / M_PI);
    EXPECT_NEAR(c.z(), 1, 1e-12);
  }
  EXPECT_NEAR(widest, 20, 1e-6);
}

}  // namespace
}  // namespace pliant
