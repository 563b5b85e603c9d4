#include "app/segment/photo_or_render.h"

#include <gtest/gtest.h>

#include "app/segment/segment_stage.h"
#include "tests/gaussians/photo_files.h"

namespace pliant {
namespace {

std::vector<Camera> cameras_named(const std::vector<std::string>& names) {
  std::vector<Camera> cameras(names.size());
  for (size_t c = 0; c < names.size(); ++c) cameras[c].name = names[c];
  return cameras;
}

TEST(PhotoOrRender, ThePhotoIsTurnedWhereOnlyTheUprightOneFits) {
  const TemporaryFolder folder;
  // Flag 6: the top of the upright picture is the left side of the stored one.
  const std::string stored = encoded(".jpg", picture_of(48, 32, [](int x, int, int) { return 5 * x; }));
  Scene scene;
  scene.cameras = cameras_named({"a"});
  Camera& camera = scene.cameras[0];
  camera.photo = folder.file("a.jpg", with_orientation(stored, 6, true)).string();
  camera.width = 32;
  camera.height = 48;
  const ImageF upright = photo_or_render(scene, 0);
  ASSERT_EQ(upright.width, 32);
  ASSERT_EQ(upright.height, 48);
  for (int y = 0; y < 48; ++y) EXPECT_NEAR(255 * upright(7, y), 5 * y, 4) << y;
  std::swap(camera.width, camera.height);
  const ImageF as_stored = photo_or_render(scene, 0);
  for (int x = 0; x < 48; ++x) EXPECT_NEAR(255 * as_stored(x, 7), 5 * x, 4) << x;
  std::swap(camera.width, camera.height);
  folder.file("a.jpg", with_orientation(stored, 3, true));
  expect_error(Failure::kInput, {"a.jpg", "48x32", "32x48"}, [&] { photo_or_render(scene, 0); });
}

TEST(PhotoSequence, IsInTheOrderOfNamesWhateverTheOrderOfRows) {
  EXPECT_EQ(photo_sequence(cameras_named({"f10", "f2", "f1", "f9"})), (std::vector<int>{2, 1, 3, 0}));
  EXPECT_EQ(photo_sequence(cameras_named({"v00", "v01", "v02"})), (std::vector<int>{0, 1, 2}));
  std::vector<Camera> cameras = cameras_named({"a", "b"});
  cameras[0].photo = "photos/12.png";
  EXPECT_EQ(photo_sequence(cameras), (std::vector<int>{0, 1}));
  cameras[1].photo = "photos/7.png";
  EXPECT_EQ(photo_sequence(cameras), (std::vector<int>{1, 0}));
}

TEST(HeldOutCameras, AreEveryEighthByNameWhateverTheOrderOfRows) {
  std::vector<std::string> names;
  for (char c = 'a'; c < 'a' + 18; ++c) names.push_back(std::string(1, c));
  EXPECT_EQ(held_out_cameras(cameras_named(names)), (std::vector<int>{0, 8, 16}));
  std::swap(names[0], names[3]);
  std::swap(names[8], names[17]);
  EXPECT_EQ(held_out_cameras(cameras_named(names)), (std::vector<int>{3, 16, 17}));
}

}  // namespace
}  // namespace pliant
