#include "segmentation/field/known_labels.h"

#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "segmentation/select/selection.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

// A Gaussian much smaller than a pixel is opaque by the low-pass filter alone.
TEST(IdPictures, ShowTheSceneAsItsRasteriserDoes) {
  GaussianCloud cloud;
  add_disc(cloud, Vec3f::Zero(), Vec3f::UnitZ(), 0.002f, Vec3f(1, 0, 0));
  const Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 21, 21, 100);
  const std::vector<uint32_t> label = {5};
  for (const bool antialiased : {false, true}) {
    Segmentation of = segmentation_of_labels(label, {}, cloud, {camera}, 1, antialiased);
    EXPECT_EQ(of.class_cameras[0].size(), antialiased ? 0u : 1u);
    EXPECT_EQ(render_ids(of, cloud, camera)(10, 10), antialiased ? 0u : 5u);
    of.screen_variance = 0.2;  // the filter of the labels
    EXPECT_EQ(render_ids(of, cloud, camera)(10, 10), antialiased ? 0u : 5u);
  }
}

// The classifier gives the labels back, for more classes than channels too.
TEST(KnownLabels, ComeBackFromTheAttributes) {
  const MadeScene scene = made_scene(two_balls(), 2);
  for (const size_t classes : {40, 600}) {
    std::vector<uint32_t> label;
    for (size_t p = 0; p < scene.cloud.size(); ++p) label.push_back(static_cast<uint32_t>(10 + 7 * (p % classes)));
    const Segmentation found = segmentation_of_labels(label, {{10, "ten"}}, scene.cloud, scene.cameras, 3);
    EXPECT_EQ(found.label, label);
    EXPECT_EQ(found.class_id.size(), classes);
    EXPECT_EQ(found.class_name[0], "ten");
    EXPECT_EQ(found.class_name[1], "17");
    for (const float c : found.confidence) EXPECT_GT(c, 0.95f);
  }
}

TEST(KnownLabels, AShapeHoldsExactlyWhatLiesInIt) {
  const MadeScene scene = made_scene(two_balls());
  const auto shape = SelectionShape::from_aabb({-0.7, -0.25, 0.01, -0.02, 0.45, 0.65});
  const Segmentation found =
      segmentation_of_members("--aabb", shape_members(shape, scene.cloud), scene.cloud, scene.cameras);
  size_t ball = 0, right = 0;
  for (size_t p = 0; p < scene.truth.size(); ++p) {
    const bool object = found.label[p] == SelectionShape::kObject;
    EXPECT_EQ(object, shape.contains(scene.cloud.position[p]));
    ball += scene.truth[p] == 300;
    right += object && scene.truth[p] == 300;
  }
  EXPECT_GT(right, 0.95 * ball);
  EXPECT_EQ(found.class_cameras[0].size(), scene.cameras.size()) << "every view shows it";
}

// A disc of 15 pixels in a large picture; of windows of it and of the whole picture the same is asked.
TEST(KnownLabels, ASmallObjectIsSeenInLargePictures) {
  MadeScene scene = made_scene({}, 0);
  add_disc(scene.cloud, Vec3f(0, 0, 0.02f), Vec3f::UnitZ(), 0.004f, Vec3f(1, 0, 0));
  std::vector<uint8_t> member(scene.cloud.size(), 0);
  member.back() = 1;
  for (const double x : {-0.2, 0.0, 0.2})
    scene.cameras.push_back(look_at({x, 0, 2}, {x, 0, 0}, {0, 1, 0}, 1600, 1200, 1440));
  std::vector<Camera> windows = scene.cameras;
  for (Camera& camera : windows) {
    const Vec3d at = camera.cam_from_world * Vec3d(0, 0, 0.02);
    camera.cx -= std::floor(camera.fx * at.x() / at.z() + camera.cx) - 100;
    camera.cy -= std::floor(camera.fy * at.y() / at.z() + camera.cy) - 100;
    camera.width = camera.height = 200;
  }
  const auto views = [&](const std::vector<Camera>& cameras) {
    const Segmentation of = segmentation_of_members("--sphere", member, scene.cloud, cameras, true);
    return of.class_cameras[class_of_id(of, SelectionShape::kObject)];
  };
  EXPECT_EQ(views(scene.cameras), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(views(windows), (std::vector<int>{0, 1, 2}));
}

TEST(KnownLabels, WhatNoCameraSeesIsNoObject) {
  const MadeScene scene = made_scene(two_balls(), 2);
  std::vector<uint8_t> member(scene.cloud.size(), 0);
  expect_error(Failure::kUsage, {"--click", "no camera"},
               [&] { segmentation_of_members("--click", member, scene.cloud, scene.cameras); });
  member[0] = 1;
  expect_error(Failure::kUsage, {"--click", "1 Gaussians", "no camera"},
               [&] { segmentation_of_members("--click", member, scene.cloud, {}); });
}

}  // namespace
}  // namespace pliant
