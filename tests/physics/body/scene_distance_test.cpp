// Signed distance of a scene of Gaussians: a table and a wall with known surfaces.

#include "physics/body/scene_distance.h"

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr float kTable = 0.1f, kWall = 0.9f;  // z of the table's top, x of the wall

void add(GaussianCloud& cloud, const Vec3f& x, const Vec3f& scale, uint64_t seed) {
  cloud.resize(cloud.size() + 1);
  cloud.position.back() = x;
  // Flat discs, turned a little at random about a tilted axis.
  Random random(4, seed);
  const Vec3f axis(random.normal(), random.normal(), random.normal());
  const float half = 0.04f * static_cast<float>(random.normal());
  cloud.rotation.back() << std::cos(half), std::sin(half) * axis.normalized();
  cloud.log_scale.back() = scale.array().log();
  cloud.opacity_logit.back() = 4;
}

/// Table z = kTable for x in 0 .. kWall, wall x = kWall above it; noise of 2 mm; some floaters in the air.
GaussianCloud table_and_wall() {
  GaussianCloud cloud;
  uint64_t seed = 0;
  const auto noise = [&](int axis) { return 0.002f * static_cast<float>(Random(8, seed, axis).normal()); };
  for (int i = 0; i < 45; ++i)
    for (int j = 0; j < 50; ++j) {
      ++seed;
      const float u = (i + 0.5f) * 0.02f, v = (j + 0.5f) * 0.02f;
      add(cloud, Vec3f(u + noise(0), v + noise(1), kTable + noise(2)), Vec3f(0.012f, 0.012f, 0.002f), seed);
      if (i < 40) add(cloud, Vec3f(kWall + noise(3), v + noise(4), kTable + u), Vec3f(0.002f, 0.012f, 0.012f), seed);
    }
  for (int k = 0; k < 12; ++k) {
    Random random(12, k);
    add(cloud, Vec3f(random.uniform(0.1, 0.8), random.uniform(0.1, 0.9), random.uniform(0.3, 0.8)),
        Vec3f::Constant(0.01f), k);
  }
  return cloud;
}

std::vector<Vec3f> cameras() { return {{0.1f, 0.1f, 0.9f}, {0.2f, 0.9f, 0.7f}, {-0.3f, 0.5f, 0.8f}}; }

TEST(SceneDistance, ATableAndAWallHaveTheirDistancesAndNormals) {
  const std::vector<Surfel> surfels = make_surfels({}, table_and_wall());
  SceneDistanceOptions options;
  options.box.add(Vec3f(0.2f, 0.2f, 0.0f));
  options.box.add(Vec3f(1.0f, 0.8f, 0.6f));
  options.spacing = 0.0125;
  options.viewpoints = cameras();
  const SceneDistanceResult result = make_scene_distance(options, surfels);
  EXPECT_GE(result.summary.floaters, 8);
  EXPECT_LT(result.summary.floaters, 30);
  double sum = 0, worst = 0, turned = 0;
  int count = 0;
  for (int i = 0; i < 3000; ++i) {
    Random random(2, i);
    const Vec3d x(random.uniform(0.25, 0.95), random.uniform(0.25, 0.75), random.uniform(0.04, 0.5));
    const double table = x.z() - kTable, wall = kWall - x.x(), truth = std::min(table, wall);
    if (std::abs(truth) > 0.05 || std::max(table, wall) < 0.1) continue;  // the truncated part; the corner
    const auto at = result.grid.sample(x);
    const double error = std::abs(at.distance - truth);
    const Vec3d normal = table < wall ? Vec3d(0, 0, 1) : Vec3d(-1, 0, 0);
    sum += error * error;
    worst = std::max(worst, error);
    ++count;
    turned += std::acos(std::min(1.0, at.normal.dot(normal)));
  }
  ASSERT_GT(count, 300);
  std::printf("distance error rms %.2f mm, worst %.2f mm; normals off by %.2f degrees in the mean; %d floaters\n",
              1000 * std::sqrt(sum / count), 1000 * worst, turned / count * 57.3, result.summary.floaters);
  EXPECT_LT(std::sqrt(sum / count), 0.002);  // the noise of the Gaussians
  EXPECT_LT(worst, 0.008);
  EXPECT_LT(turned / count, 0.1);
}

TEST(SceneDistance, BesideTheEndOfATableIsNothing) {
  GaussianCloud cloud;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) add(cloud, Vec3f(0.02f * i, 0.02f * j, 0), Vec3f(0.012f, 0.012f, 0.002f), i * 30 + j);
  SceneDistanceOptions options;
  options.box.add(Vec3f(-0.3f, -0.3f, -0.2f));
  options.box.add(Vec3f(0.9f, 0.9f, 0.3f));
  options.spacing = 0.02;
  options.viewpoints = {Vec3f(0.3f, 0.3f, 2)};
  const SceneDistanceResult result = make_scene_distance(options, make_surfels({}, cloud));
  EXPECT_LT(result.grid.sample(Vec3d(0.3, 0.3, -0.1)).distance, -0.09);
  EXPECT_GT(result.grid.sample(Vec3d(0.3, 0.3, 0.1)).distance, 0.09);
  for (const Vec3d& beside : {Vec3d(0.8, 0.3, -0.05), Vec3d(-0.2, 0.3, -0.02), Vec3d(0.3, 0.85, -0.1)})
    EXPECT_GT(result.grid.sample(beside).distance, 0.0) << beside.transpose();
}

TEST(SceneDistance, SurfelsOfTheObjectItselfAndOfNothingLeaveNoObstacle) {
  const std::vector<Surfel> surfels = make_surfels({}, table_and_wall());
  SceneDistanceOptions options;
  options.box.add(Vec3f(0.2f, 0.2f, 0.0f));
  options.box.add(Vec3f(0.6f, 0.6f, 0.3f));
  const std::vector<uint8_t> all(surfels.size(), 1);
  EXPECT_TRUE(make_scene_distance(options, surfels, all).grid.value.empty());
  EXPECT_TRUE(make_scene_distance(options, {}).grid.value.empty());
  options.spacing = 1e-6;
  EXPECT_THROW(make_scene_distance(options, surfels), Error);
  options.box = {};
  EXPECT_THROW(make_scene_distance(options, surfels), Error);
}

TEST(SceneDistance, ABallDroppedOnTheTableRestsAtTheRightHeight) {
  SceneDistanceOptions options;
  options.box.add(Vec3f(0.2f, 0.2f, -0.1f));
  options.box.add(Vec3f(0.7f, 0.7f, 0.5f));
  options.spacing = 0.015;
  options.viewpoints = cameras();
  const SceneDistanceResult scene = make_scene_distance(options, make_surfels({}, table_and_wall()));
  constexpr double dx = 0.02, radius = 0.07;
  auto ball = fixture::fill_shape<double>(Vec3d::Constant(2 * radius), dx, 2, 1.0, 1e5, 0.3, 1000, [&](const Vec3d& x) {
    return (x - Vec3d::Constant(radius)).norm() < radius;
  });
  for (Vec3d& x : ball.position) x += Vec3d(0.38, 0.38, kTable + 0.03);
  Interaction table;
  table.type = InteractionType::kCollider;
  table.friction = 0.5;
  table.distance = std::make_shared<SignedDistanceGrid>(scene.grid);
  SimulateOptions run;
  run.fps = 50;
  run.duration = 0.8;
  run.damping_time = 0.2;
  const auto end = simulate<double>(run, ball, {table}, initial_state(ball)).state;
  Vec3d centre = Vec3d::Zero(), velocity = Vec3d::Zero();
  for (size_t i = 0; i < end.size(); ++i) {
    centre += end.x[i];
    velocity += end.v[i];
  }
  centre /= static_cast<double>(end.size());
  velocity /= static_cast<double>(end.size());
  EXPECT_NEAR(centre.z(), kTable + radius, 0.5 * dx);
  EXPECT_LT(velocity.norm(), 0.03);
}

}  // namespace
}  // namespace pliant
