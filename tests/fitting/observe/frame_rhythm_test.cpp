// Frames that are shown again or missing at even distances are told from the changes between frames; a swing has no
// rhythm.

#include "fitting/observe/frame_rhythm.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace pliant {
namespace {

constexpr int kFrames = 80;

/// A damped swing with `period` frames of its film in a period, of which frame t shows `filmed(t)`.
std::vector<float> changes(double period, double phase, const std::function<int(int)>& filmed) {
  const auto place = [&](int t) {
    return std::exp(-0.02 * filmed(t)) * std::sin(2 * M_PI * filmed(t) / period + phase);
  };
  std::vector<float> change(kFrames, 0);
  for (int t = 1; t < kFrames; ++t) change[t] = static_cast<float>(std::abs(place(t) - place(t - 1)) + 1e-4);
  return change;
}

TEST(FrameRhythm, RepeatedAndMissingFramesAreCountedWhateverTheSwing) {
  for (double period = 9.3; period < 60; period *= 1.13)
    for (const double phase : {0.0, 0.7, 1.9}) {
      const auto expect = [&](const std::function<int(int)>& filmed, int length, int repeated, int missing) {
        const FrameRhythm rhythm = find_rhythm(changes(period, phase, filmed));
        EXPECT_EQ(rhythm.period, length) << "swing of " << period << " frames, phase " << phase;
        EXPECT_EQ(rhythm.repeated, repeated);
        EXPECT_EQ(rhythm.missing, missing);
        EXPECT_NEAR(rhythm.share(), static_cast<double>(length - repeated + missing) / length, 1e-12);
      };
      expect([](int t) { return t / 2; }, 2, 1, 0);      // 12 frames a second stored as 24
      expect([](int t) { return t / 3; }, 3, 2, 0);      // 8 as 24
      expect([](int t) { return t * 4 / 5; }, 5, 1, 0);  // 24 as 30
    }
}

TEST(FrameRhythm, ASwingHasNone) {
  int found = 0, cases = 0;
  for (double period = 9.3; period < 200; period *= 1.031)
    for (double phase = 0; phase < 3.1; phase += 0.31, ++cases)
      found += find_rhythm(changes(period, phase, [](int t) { return t; })).period > 0;
  EXPECT_LE(found, cases / 100);  // at the multiples alone
  EXPECT_EQ(find_rhythm(std::vector<float>(50, 0.0f)).period, 0);
  EXPECT_EQ(find_rhythm(std::vector<float>{0.0f}).period, 0);
  EXPECT_EQ(find_rhythm(std::vector<float>{}).period, 0);
}

}  // namespace
}  // namespace pliant
