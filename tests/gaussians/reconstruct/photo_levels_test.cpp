// Photos at smaller sizes: what does not count has no part in them.

#include <gtest/gtest.h>

#include "gaussians/reconstruct/trainer.h"

namespace pliant {
namespace {

TEST(PhotoLevels, ColoursOfPixelsThatDoNotCountAreInNoSmallerPicture) {
  TrainingPhoto photo;
  photo.camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 8, 6, 9);
  photo.pixels = ImageU8(8, 6, 3, 51);
  photo.weight = ImageU8(8, 6, 1, 255);
  photo.alpha = ImageU8(8, 6, 1, 204);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 3; ++x) {
      std::fill_n(photo.pixels.at(x, y), 3, 255);
      photo.weight(x, y) = photo.alpha(x, y) = 0;
    }
  Camera camera;
  ImageF pixels, weight;
  photo_at_level(photo, 1, camera, pixels, weight);
  ASSERT_EQ(pixels.width, 4);
  ASSERT_EQ(pixels.height, 3);
  for (int y = 0; y < 3; ++y) {
    EXPECT_EQ(weight(0, y), 0);
    EXPECT_NEAR(weight(1, y), 0.5, 1e-6);
    EXPECT_NEAR(weight(2, y), 1, 1e-6);
    for (int x = 1; x < 4; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixels(x, y, c), 0.2, 1e-6) << x;
  }
  change_backdrop(photo, Vec3f::Zero(), Vec3f::Ones(), pixels);
  for (int x = 1; x < 4; ++x) EXPECT_NEAR(pixels(x, 1, 0), 0.2 + 0.2, 1e-6) << x;
  // At full size all is as it is.
  photo_at_level(photo, 0, camera, pixels, weight);
  EXPECT_NEAR(pixels(1, 1, 2), 1, 1e-6);
  EXPECT_EQ(weight(2, 1), 0);
  EXPECT_NEAR(pixels(3, 1, 2), 0.2, 1e-6);
}

}  // namespace
}  // namespace pliant
