// Laws of the shared types: quaternions, selection and appending of Gaussians, ordered sums, random streams,
// nearest neighbours against brute force, quantiles against sorting.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "gaussians/base/camera.h"
#include "gaussians/base/disjoint_sets.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

GaussianCloud random_cloud(int n, int degree, uint64_t seed) {
  GaussianCloud cloud;
  cloud.sh_degree = degree;
  cloud.resize(n);
  Random random(seed);
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      cloud.position[i][k] = random.normal();
      cloud.log_scale[i][k] = random.normal();
    }
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = random.normal();
    cloud.opacity_logit[i] = random.normal();
  }
  for (float& value : cloud.sh) value = random.normal();
  return cloud;
}

TEST(Quaternion, RoundTripThroughTheMatrixUpToSign) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    Vec4f q(random.normal(), random.normal(), random.normal(), random.normal());
    q.normalize();
    const Vec4f back = quaternion_wxyz(rotation_matrix<float>(q));
    EXPECT_NEAR(std::abs(back.dot(q)), 1.0f, 1e-5f);
  }
}

TEST(Quaternion, QuarterTurnAboutZTakesXToY) {
  const Mat3f R = rotation_matrix<float>(Vec4f(std::sqrt(0.5f), 0, 0, std::sqrt(0.5f)));
  EXPECT_LT((R * Vec3f::UnitX() - Vec3f::UnitY()).norm(), 1e-6f);
}

TEST(GaussianCloud, SelectAndAppendKeepEveryField) {
  const GaussianCloud a = random_cloud(5, 1, 2), b = random_cloud(3, 3, 3);
  GaussianCloud joined = a;
  joined.append(b);
  ASSERT_EQ(joined.size(), 8u);
  EXPECT_EQ(joined.sh_degree, 3);
  EXPECT_EQ(joined.sh_of(1)[11], a.sh_of(1)[11]);
  EXPECT_EQ(joined.sh_of(1)[12], 0.0f);
  const std::vector<int> pick = {7, 0};
  const GaussianCloud chosen = joined.select(pick);
  EXPECT_EQ(chosen.position[0], b.position[2]);
  EXPECT_EQ(chosen.sh_of(0)[47], b.sh_of(2)[47]);
  EXPECT_EQ(chosen.opacity_logit[1], a.opacity_logit[0]);
}

TEST(GaussianCloud, ColorOfTheDcCoefficientIsItsBasisValueAboutGrey) {
  // The first basis function is 1 / (2 sqrt pi).
  const float sh[] = {0, 1, -2};
  const Vec3f color = dc_color(sh);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(color[k], 0.5 + sh[k] / (2 * std::sqrt(std::numbers::pi)), 1e-7);
    EXPECT_NEAR(sh_of_color(color[k]), sh[k], 1e-6);
  }
}

TEST(DisjointSets, AreKnownByTheSmallestOfJoinedMembersAndByTheOneThatOthersJoinInto) {
  DisjointSets sets(6);
  EXPECT_TRUE(sets.join(4, 1));
  EXPECT_TRUE(sets.join(2, 4));
  for (const int i : {1, 2, 4}) EXPECT_EQ(sets.find(i), 1);
  EXPECT_TRUE(sets.join_into(5, 3));
  EXPECT_TRUE(sets.join_into(3, 2));
  for (const int i : {1, 2, 3, 4, 5}) EXPECT_EQ(sets.find(i), 5);
  EXPECT_FALSE(sets.join_into(4, 5));
  EXPECT_EQ(sets.find(4), 5);
  EXPECT_EQ(sets.add(), 6);
  EXPECT_EQ(sets.find(0), 0);
}

TEST(OrderedSum, IsEqualBitForBitForAnyThreadCount) {
  std::vector<float> values(3000000);
  Random random(4);
  for (float& v : values) v = static_cast<float>(random.normal());
  auto sum = [&](int threads) {
    const int before = omp_get_max_threads();
    omp_set_num_threads(threads);
    const float total =
        ordered_sum(static_cast<std::ptrdiff_t>(values.size()), 0.0f, [&](std::ptrdiff_t i) { return values[i]; });
    omp_set_num_threads(before);
    return total;
  };
  const float one = sum(1);
  EXPECT_EQ(one, sum(2));
  EXPECT_EQ(one, sum(3));
  EXPECT_NEAR(one, std::accumulate(values.begin(), values.end(), 0.0), 0.5);
}

TEST(Random, StreamDependsOnlyOnSeedElementAndStep) {
  EXPECT_EQ(Random(1, 2, 3).bits(), Random(1, 2, 3).bits());
  EXPECT_NE(Random(1, 2, 3).bits(), Random(1, 3, 2).bits());
  EXPECT_NE(Random(1, 2, 3).bits(), Random(2, 2, 3).bits());
  double mean = 0, square = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) {
    const double x = Random(7, i).normal();
    mean += x / n;
    square += x * x / n;
  }
  EXPECT_NEAR(mean, 0.0, 0.01);
  EXPECT_NEAR(square, 1.0, 0.02);
}

TEST(NearestPoints, AgreesWithBruteForce) {
  const GaussianCloud cloud = random_cloud(500, 0, 5);
  const std::vector<int> found = k_nearest(cloud.position, cloud.position, 4);
  for (size_t q = 0; q < cloud.size(); ++q) {
    std::vector<int> order(cloud.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) {
      return (cloud.position[i] - cloud.position[q]).norm() < (cloud.position[j] - cloud.position[q]).norm();
    });
    for (int k = 0; k < 4; ++k) EXPECT_EQ(found[q * 4 + k], order[k]);
  }
}

TEST(Camera, LookAtPutsTheTargetAtTheCentreAndUpAtTheTop) {
  const Camera camera = look_at({1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 400, 300, 350);
  const Eigen::Vector3d target = camera.cam_from_world * Eigen::Vector3d(0, 0, 0);
  EXPECT_NEAR(target.x(), 0, 1e-12);
  EXPECT_NEAR(target.y(), 0, 1e-12);
  EXPECT_GT(target.z(), 0);
  EXPECT_LT((camera.cam_from_world * Eigen::Vector3d(0, 0, 0.1)).y(), 0);
  EXPECT_LT((camera.centre() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_NEAR(camera.cam_from_world.linear().determinant(), 1.0, 1e-12);
}

TEST(Quantile, IsThePlaceInAscendingOrderThatTheShareOfTheValuesReaches) {
  Random random(5);
  for (const int n : {1, 2, 3, 10, 101}) {
    std::vector<float> values(n);
    for (float& value : values) value = random.normal();
    std::vector<float> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(quantile(values, 0), sorted.front());
    EXPECT_EQ(quantile(values, 0.5), sorted[n / 2]);
    EXPECT_EQ(quantile(values, 0.9), sorted[n * 9 / 10]);
    EXPECT_EQ(quantile(values, 1), sorted.back());
  }
  EXPECT_EQ(quantile(std::vector<int>(), 0.5), 0);
}

}  // namespace
}  // namespace pliant
