// Filling by translation: what repeats is continued exactly under slowly varying light, what no translation reaches is
// said, and noise is refused.  And the picture that it copies from: dark lines stay, fading ends do not darken.

#include "segmentation/repair/shift_fill.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"
#include "segmentation/repair/plane_picture.h"

namespace pliant {
namespace {

constexpr int kWidth = 96, kHeight = 80, kTile = 8;

struct Holed {
  ImageF picture = ImageF(kWidth, kHeight, 3), whole = ImageF(kWidth, kHeight, 3);
  ImageU8 known = ImageU8(kWidth, kHeight, 1), target = ImageU8(kWidth, kHeight, 1);
};

/// Random tiles (or noise everywhere) with a linear drift of light, and a round hole.
Holed tiles(bool repeat, float drift, double radius = 15) {
  Holed made;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool hole = std::hypot(x - 48, y - 40) < radius;
      made.target(x, y) = hole;
      made.known(x, y) = !hole;
      for (int k = 0; k < 3; ++k) {
        const uint64_t cell = repeat ? (y % kTile) * kTile + x % kTile : y * kWidth + x;
        made.whole(x, y, k) =
            static_cast<float>(0.2 + 0.5 * Random(3, cell, k).uniform()) + drift * static_cast<float>(x) / kWidth;
        made.picture(x, y, k) = hole ? 0.0f : made.whole(x, y, k);
      }
    }
  return made;
}

TEST(ShiftFill, TilesAreContinuedUnderDriftingLight) {
  const Holed made = tiles(true, 0.1f);
  const auto fill = shift_fill({}, made.picture, made.known, made.target);
  ASSERT_TRUE(fill.has_value());
  for (size_t i = 0; i < made.target.data.size(); ++i) {
    EXPECT_EQ(fill->left.data[i], 0);
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(fill->picture.data[3 * i + k], made.whole.data[3 * i + k], made.target.data[i] ? 0.02f : 0.0f);
  }
}

TEST(ShiftFill, WhatNoTranslationReachesIsLeft) {
  Holed made = tiles(true, 0, 7);
  const auto unknown = [](int x, int y) { return x % kTile == 4 && y % kTile == 4; };
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (unknown(x, y)) made.known(x, y) = 0;
  const auto fill = shift_fill({}, made.picture, made.known, made.target);
  ASSERT_TRUE(fill.has_value());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (!made.target(x, y)) continue;
      EXPECT_EQ(fill->left(x, y), unknown(x, y));
      EXPECT_NEAR(fill->picture(x, y), unknown(x, y) ? 0.0f : made.whole(x, y), 1e-3f) << x << ' ' << y;
    }
}

TEST(ShiftFill, NoiseIsRefused) {
  const Holed made = tiles(false, 0);
  EXPECT_FALSE(shift_fill({}, made.picture, made.known, made.target).has_value());
}

TEST(PlanePicture, ATransparentLineStaysDarkAndAFadingEndDoesNot) {
  RenderResult picture;
  picture.color = ImageF(30, 20, 3);
  picture.alpha = ImageF(30, 20, 1);
  constexpr float kColor = 0.6f;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const float alpha = x == 8 ? 0.4f : std::clamp(0.2f * (26 - x), 0.0f, 0.96f);
      picture.alpha(x, y) = alpha;
      for (int k = 0; k < 3; ++k) picture.color(x, y, k) = kColor * alpha;
    }
  const ImageF color = surface_color(picture);
  const ImageU8 known = source_mask(picture, ImageU8(30, 20, 1));
  EXPECT_NEAR(color(8, 10), kColor * 0.4f / 0.96f, 1e-4f);
  for (int x : {3, 7, 9, 20, 22, 24}) EXPECT_NEAR(color(x, 10), kColor, 1e-4f) << x;
  for (int x : {3, 8, 20}) EXPECT_TRUE(known(x, 10)) << x;
  for (int x : {23, 25, 28}) EXPECT_FALSE(known(x, 10)) << x;
}

}  // namespace
}  // namespace pliant
