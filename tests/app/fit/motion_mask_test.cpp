#include <gtest/gtest.h>

#include <algorithm>

#include "app/fit/fit_scene.h"

namespace pliant {
namespace {

/// Nothing moves in the first two frames; a square appears in the third.
FitView seen() {
  FitView view;
  view.moving = ImageF(40, 30, 1);
  for (int f = 0; f < 3; ++f) view.video.frames.push_back(ImageF(40, 30, 3));
  for (int y = 10; y < 16; ++y)
    for (int x = 20; x < 26; ++x) view.video.frames[2](x, y, 1) = 1;
  return view;
}

TEST(MotionMask, LaterFramesDoNotShapeTheMaskOfEarlierOnes) {
  const FitView view = seen();
  const ImageF early = motion_mask(view, 2, 2), late = motion_mask(view, 3, 2);
  EXPECT_EQ(std::count(early.data.begin(), early.data.end(), 0.0f), 40 * 30);
  EXPECT_EQ(late(22, 12), 1);
  EXPECT_EQ(late(18, 12), 1);  // grown by 2
  EXPECT_EQ(late(16, 12), 0);
}

TEST(MotionMask, WhatIsHiddenInTheFirstFrameOrInALaterOneIsNoMotion) {
  FitView view = seen();
  view.compared.assign(3, ImageU8(40, 30, 1));
  for (ImageU8& compared : view.compared) compared.data.assign(compared.data.size(), 255);
  EXPECT_EQ(motion_mask(view, 3, 2)(22, 12), 1);
  for (const int hidden : {0, 2}) {
    FitView some = view;
    some.compared[hidden].data.assign(some.compared[hidden].data.size(), 0);
    const ImageF mask = motion_mask(some, 3, 2);
    EXPECT_EQ(std::count(mask.data.begin(), mask.data.end(), 0.0f), 40 * 30) << hidden;
  }
}

TEST(MotionMask, WhatIsNotComparedIsLeftOut) {
  FitView view = seen();
  view.compared.assign(1, ImageU8(40, 30, 1));
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 22; ++x) view.compared[0](x, y) = 255;
  ImageF mask = motion_mask(view, 3, 2);
  leave_out(mask, view, 2);
  EXPECT_EQ(mask(21, 12), 1);
  EXPECT_EQ(mask(22, 12), 0);
  EXPECT_FALSE(is_compared(view, 0, -1, 5));
  EXPECT_TRUE(is_compared(view, 0, 3, 5));
}

}  // namespace
}  // namespace pliant
