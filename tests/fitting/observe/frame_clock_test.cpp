// The rate of a video is one over the step of its frames, whatever is missing among them and however their instants are
// rounded.

#include "fitting/observe/frame_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace pliant {
namespace {

/// Instants of frames at a rate without some, rounded to `grain`; 0 = not rounded.
std::vector<double> stamps_of(int frames, double rate, double grain, const std::set<int>& missing = {}) {
  std::vector<double> out;
  for (int f = 0; f < frames; ++f)
    if (!missing.count(f)) out.push_back(grain > 0 ? std::round(f / rate / grain) * grain : f / rate);
  return out;
}

double average_rate(const std::vector<double>& stamps) {
  return static_cast<double>(stamps.size() - 1) / (stamps.back() - stamps[0]);
}

TEST(FrameClock, MissingFramesDoNotChangeTheRate) {
  for (const double rate : {12.0, 24000.0 / 1001, 24.0, 25.0, 30000.0 / 1001, 30.0, 60.0, 120.0})
    for (const double grain : {0.0, 1.0 / 90000, 1e-3})
      for (const std::set<int>& missing :
           {std::set<int>{40}, std::set<int>{20, 21, 22, 23, 24}, std::set<int>{7, 60}}) {
        const std::vector<double> stamps = stamps_of(200, rate, grain, missing);
        EXPECT_NEAR(clock_of(stamps, average_rate(stamps)).rate, rate, 1e-9 * rate) << grain;
      }
}

TEST(FrameClock, ARateThatNobodyUsesIsMeasured) {
  const std::vector<double> stamps = stamps_of(200, 21.7, 0, {40});
  EXPECT_NEAR(clock_of(stamps, average_rate(stamps)).rate, 21.7, 1e-6);
}

TEST(FrameClock, EvenStepsTellTheRateWhateverTheFileSays) {
  for (const double rate : {24.0, 30000.0 / 1001, 30.0, 120.0})
    for (const double grain : {0.0, 1.0 / 90000, 1e-3}) {
      const std::vector<double> stamps = stamps_of(240, rate, grain);
      // Some files tell frames by the time to the end of the last one, or of the sound.
      EXPECT_NEAR(clock_of(stamps, 240 / (stamps.back() + 0.5)).rate, rate, 1e-9 * rate) << grain;
    }
}

TEST(FrameClock, WithinTheRoundingOrWithoutEvenStepsTheFileTellsTheRate) {
  EXPECT_EQ(clock_of(stamps_of(72, 24, 1e-3), 24.005).rate, 24.005);
  EXPECT_EQ(clock_of(stamps_of(2, 24, 0), 24).rate, 24);
  EXPECT_EQ(clock_of({}, 24).rate, 24);
  EXPECT_EQ(clock_of(stamps_of(72, 24, 0, {3}), 0).rate, 0);
  // Steps without a rhythm have only an average.
  std::vector<double> uneven = {0};
  for (int f = 1; f < 60; ++f) uneven.push_back(uneven.back() + (f % 3 == 0 ? 0.02 : f % 3 == 1 ? 0.05 : 0.11));
  EXPECT_EQ(clock_of(uneven, 16.7).rate, 16.7);
}

TEST(FrameClock, RoundedInstantsAreThoseOfTheRateAgain) {
  struct Case {
    double rate, grain;
  };
  for (const Case& c : {Case{24, 1e-2}, Case{33, 1e-2}, Case{60, 1e-3}, Case{120, 1e-3}, Case{240, 1e-3},
                        Case{30000.0 / 1001, 1.0 / 600}}) {
    const std::vector<double> stamps = stamps_of(150, c.rate, c.grain);
    const FrameClock clock = clock_of(stamps, c.rate);
    EXPECT_EQ(clock.rate, c.rate);
    for (int f = 0; f < 150; ++f) EXPECT_NEAR(clock.instant(stamps[f]), f / c.rate, 1e-9) << c.rate << " " << f;
  }
  // Instants that no rounding explains stay.
  std::vector<double> shaken = stamps_of(150, 30, 0);
  for (size_t f = 1; f < shaken.size(); ++f) shaken[f] += 4e-3 * std::sin(1.7 * static_cast<double>(f));
  const FrameClock clock = clock_of(shaken, 30);
  for (const double stamp : shaken) EXPECT_EQ(clock.instant(stamp), stamp);
}

}  // namespace
}  // namespace pliant
