// Which views a repair looks at, and in what size.

#include "segmentation/repair/chosen_views.h"

#include <gtest/gtest.h>

#include "segmentation/repair/repair.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

struct BallOnTable {
  GaussianCloud background, object;
  std::vector<Camera> cameras;
};

/// Object 300 of two_balls() is cut out.
BallOnTable ball_on_table(int views, int width, int height) {
  const MadeScene scene = made_scene(two_balls(), views, width, height);
  std::vector<int> object, background;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    (scene.truth[p] == 300 ? object : background).push_back(static_cast<int>(p));
  return {scene.cloud.select(background), scene.cloud.select(object), scene.cameras};
}

/// The same place, but the back to the scene.
Camera turned_away(Camera camera) {
  camera.cam_from_world = Eigen::AngleAxisd(M_PI, Vec3d::UnitY()) * camera.cam_from_world;
  return camera;
}

/// Each camera is followed by ten at about the same place that look away.
BallOnTable mostly_turned_away() {
  BallOnTable scene = ball_on_table(4, 160, 120);
  std::vector<Camera> cameras;
  for (const Camera& camera : scene.cameras)
    for (int k = 0; k <= 10; ++k) {
      cameras.push_back(k == 0 ? camera : turned_away(camera));
      cameras.back().cam_from_world.translate(Vec3d(1e-3 * k, 0, 0));
    }
  scene.cameras = cameras;
  return scene;
}

TEST(ChosenViews, ShowTheObject) {
  BallOnTable scene = mostly_turned_away();
  EXPECT_EQ(cameras_with_object({}, scene.background, scene.object, scene.cameras), (std::vector<int>{0, 11, 22, 33}));
  // A screen in front of one of them.
  const Camera& behind = scene.cameras[22];
  add_disc(scene.background, (behind.centre() + 0.5 * behind.forward()).cast<float>(), behind.forward().cast<float>(),
           0.5f, Vec3f(0, 0, 0));
  scene.background.opacity_logit.back() = 6;
  EXPECT_EQ(cameras_with_object({}, scene.background, scene.object, scene.cameras), (std::vector<int>{0, 11, 33}));
}

TEST(ChosenViews, AreEvenlyChosenAmongTheCandidatesInAnyOrder) {
  std::vector<Camera> cameras;
  for (int c = 0; c < 20; ++c) cameras.push_back(look_at({0.1 * c, 0, 2}, {0, 0, 0}, {0, 1, 0}, 40, 30, 40));
  EXPECT_EQ(choose_evenly(cameras, {3, 5, 7, 9, 11, 13}, 3), (std::vector<int>{3, 7, 11}));
  EXPECT_EQ(choose_evenly(cameras, {13, 7, 3, 11, 9, 5}, 3), (std::vector<int>{3, 7, 11}));
  EXPECT_EQ(choose_evenly(cameras, {13, 7}, 3), (std::vector<int>{7, 13}));
}

TEST(ChosenViews, FindTheHoleHoweverFewCamerasShowTheObject) {
  const BallOnTable scene = mostly_turned_away();
  RepairOptions options;
  options.max_views = 4;
  const RepairSummary summary = repair(options, scene.background, scene.object, scene.cameras).summary;
  EXPECT_TRUE(summary.object_seen);
  ASSERT_EQ(summary.hole_before.size(), 4u);
  for (size_t v = 0; v < 4; ++v) {
    EXPECT_EQ(summary.views[v] % 11, 0);
    EXPECT_GT(summary.hole_before[v], 100u);
  }
  EXPECT_LT(summary.after(), summary.before() / 50);
}

TEST(ChosenViews, WhereNoneShowsTheObjectNothingChanges) {
  BallOnTable scene = ball_on_table(6, 160, 120);
  for (Camera& camera : scene.cameras) camera = turned_away(camera);
  for (const int most : {4, 24}) {
    RepairOptions options;
    options.max_views = most;
    const RepairResult result = repair(options, scene.background, scene.object, scene.cameras);
    EXPECT_FALSE(result.summary.object_seen);
    EXPECT_EQ(result.summary.views.size(), static_cast<size_t>(std::min(most, 6)));
    EXPECT_EQ(result.summary.before(), 0u);
    EXPECT_EQ(result.background.position, scene.background.position);
    EXPECT_EQ(result.background.sh, scene.background.sh);
  }
}

TEST(ChosenViews, ARepairIsTheSameForLargerPhotos) {
  const BallOnTable small = ball_on_table(8, 160, 120), large = ball_on_table(8, 640, 480);
  RepairOptions options;
  options.longest_side = 160;
  const RepairResult one = repair(options, small.background, small.object, small.cameras);
  const RepairResult two = repair(options, large.background, large.object, large.cameras);
  EXPECT_GT(one.summary.plane_gaussians, 100u);
  EXPECT_EQ(one.summary.hole_before, two.summary.hole_before);
  EXPECT_EQ(one.summary.hole_after, two.summary.hole_after);
  EXPECT_EQ(one.background.position, two.background.position);
  EXPECT_EQ(one.background.sh, two.background.sh);
}

TEST(ChosenViews, TheSheetOfLargePhotosIsNoLargerThanThatOfTheLargestViews) {
  const BallOnTable small = ball_on_table(1, 800, 600), large = ball_on_table(1, 4000, 3000);
  RepairResult result;
  result.background = small.background;
  result.summary.views = {0};
  result.summary.hole_before = {1};
  const ImageF wanted = repair_sheet(result, small.background, small.object, small.cameras),
               sheet = repair_sheet(result, large.background, large.object, large.cameras);
  EXPECT_EQ(sheet.width, wanted.width);
  EXPECT_EQ(sheet.height, wanted.height);
  EXPECT_EQ(sheet.data, wanted.data);
}

}  // namespace
}  // namespace pliant
