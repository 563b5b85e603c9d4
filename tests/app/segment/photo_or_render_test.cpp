#include "app/segment/photo_or_render.h"

#include <gtest/gtest.h>

#include "app/segment/segment_stage.h"

namespace pliant {
namespace {

std::vector<Camera> cameras_named(const std::vector<std::string>& names) {
  std::vector<Camera> cameras(names.size());
  for (size_t c = 0; c < names.size(); ++c) cameras[c].name = names[c];
  return cameras;
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
