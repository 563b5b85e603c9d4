// Bands that are as wide as stated, too narrow and too wide by a known factor.

#include "app/statistics/calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Rows whose errors are normal and `wider` times as large as stated.
std::vector<StatedBand> rows_of(int count, double wider, uint64_t seed = 3) {
  std::vector<StatedBand> rows;
  for (int i = 0; i < count; ++i) {
    Random random(seed, i);
    const double sigma = 0.1 + random.uniform();
    rows.push_back({4 + random.normal(), sigma, sigma, 0});
    rows.back().truth = rows.back().estimate + wider * sigma * random.normal();
  }
  return rows;
}

const std::vector<double> kLevels = {0.68, 0.9};

TEST(Coverage, CountsTheBandsThatHoldTheTruth) {
  // 68 % is 0.9945 and 90 % 1.6449 standard deviations; the sides differ.
  const std::vector<StatedBand> rows = {{0, 1, 2, 1.9}, {0, 1, 2, 2.1}, {0, 1, 2, -0.9}, {0, 1, 2, -1.5}};
  EXPECT_EQ(coverage(rows, 0.68).inside, 2);
  EXPECT_EQ(coverage(rows, 0.9).inside, 4);
  EXPECT_EQ(coverage(rows, 0.9, 0.56).inside, 1);
  EXPECT_NEAR(coverage(rows, 0.9, 0.56).interval.high, clopper_pearson(1, 4).high, 1e-15);
  EXPECT_NEAR(normal_half_width(0.9), 1.6448536269514722, 1e-9);
}

TEST(Calibrate, BandsAsStatedNeedNoFactor) {
  const Calibration found = calibrate(rows_of(600, 1), kLevels, 1);
  EXPECT_NEAR(found.factor, 1, 0.12);
  for (const CalibrationLevel& level : found.levels) EXPECT_TRUE(level.stated.as_stated) << level.stated.share;
}

TEST(Calibrate, TheFactorByWhichBandsAreTooNarrowOrTooWideIsFoundOnOneHalfAndHoldsOnTheOther) {
  for (const double wider : {0.4, 2.5}) {
    const Calibration found = calibrate(rows_of(600, wider), kLevels, 1);
    EXPECT_NEAR(found.factor / wider, 1, 0.12);
    for (const CalibrationLevel& level : found.levels) {
      EXPECT_FALSE(level.stated.as_stated) << level.stated.share;
      EXPECT_EQ(level.second_half.rows, 300);
      EXPECT_TRUE(level.with_factor.as_stated) << level.with_factor.share;
      EXPECT_TRUE(level.with_one_factor.as_stated) << level.with_one_factor.share;
    }
  }
}

TEST(Calibrate, TheFactorCoversNewRowsAsOftenAsStatedForErrorsThatAreNotNormal) {
  // Cauchy's errors: no width in standard deviations fits, the order statistic does.
  double covered = 0;
  const int repetitions = 300;
  for (int r = 0; r < repetitions; ++r) {
    std::vector<StatedBand> rows;
    for (int i = 0; i < 120; ++i) rows.push_back({0, 1, 1, std::tan(M_PI * (Random(r, i).uniform() - 0.5))});
    covered += calibrate(rows, kLevels, r).levels[1].with_factor.share / repetitions;
  }
  EXPECT_NEAR(covered, 0.9 + 0.5 / 61, 0.012);
}

}  // namespace
}  // namespace pliant
