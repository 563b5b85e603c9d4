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
  EXPECT_NEAR(*found.factor, 1, 0.12);
  for (const CalibrationLevel& level : found.levels) EXPECT_TRUE(level.stated.as_stated) << level.stated.share;
}

TEST(Calibrate, TheFactorByWhichBandsAreTooNarrowOrTooWideIsFoundOnOneHalfAndHoldsOnTheOther) {
  for (const double wider : {0.4, 2.5}) {
    const Calibration found = calibrate(rows_of(600, wider), kLevels, 1);
    EXPECT_NEAR(*found.factor / wider, 1, 0.12);
    for (const CalibrationLevel& level : found.levels) {
      EXPECT_FALSE(level.stated.as_stated) << level.stated.share;
      EXPECT_EQ(level.second_half.rows, 300);
      EXPECT_TRUE(level.with_factor->as_stated) << level.with_factor->share;
      EXPECT_TRUE(level.with_one_factor->as_stated) << level.with_one_factor->share;
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
    covered += calibrate(rows, kLevels, r).levels[1].with_factor->share / repetitions;
  }
  EXPECT_NEAR(covered, 0.9 + 0.5 / 61, 0.012);
}

TEST(Calibrate, ALevelWithoutItsOrderStatisticHasNoFactor) {
  // Of n rows, the order statistic ceil((n + 1) 0.9) is one of them from n = 9 on.
  for (const int half : {4, 8, 9}) {
    const Calibration found = calibrate(rows_of(2 * half, 1), kLevels, 1);
    ASSERT_TRUE(found.levels[0].factor && found.factor) << half;
    EXPECT_EQ(found.levels[1].factor.has_value(), half == 9) << half;
    EXPECT_EQ(found.levels[1].with_factor.has_value(), half == 9) << half;
    EXPECT_TRUE(found.levels[1].with_one_factor) << half;
    if (half < 9) {
      EXPECT_NEAR(*found.factor, *found.levels[0].factor, 1e-12);
    }
  }
}

TEST(Calibrate, TheFactorIsTheOrderStatisticAlsoWhereItsRankIsAWholeNumber) {
  // (n + 1) q, which binary numbers miss for some n.
  struct Case {
    int half;
    double nominal;
    int rank;
  };
  for (const Case& c : {Case{74, 0.68, 51}, Case{149, 0.68, 102}, Case{174, 0.68, 119}, Case{24, 0.68, 17},
                        Case{75, 0.68, 52}, Case{9, 0.9, 9}, Case{99, 0.9, 90}}) {
    std::vector<StatedBand> rows;
    for (int i = 1; i <= 2 * c.half; ++i) rows.push_back({0, 1, 1, static_cast<double>(i)});
    const std::vector<double> levels = {c.nominal};
    const CalibrationLevel level = calibrate(rows, levels, 1).levels[0];
    // It covers as many bands of the first half as its rank; 1e-9 for the rounding of the band that gives it.
    const int covered = coverage(rows, c.nominal, *level.factor * (1 + 1e-9)).inside;
    EXPECT_EQ(covered - level.with_factor->inside, c.rank) << c.half;
  }
}

TEST(Calibrate, EstimatesThatAreTheTruthNeedNoWidth) {
  std::vector<StatedBand> rows(40, {1, 1, 1, 1});
  const Calibration exact = calibrate(rows, kLevels, 1);
  for (const CalibrationLevel& level : exact.levels) EXPECT_EQ(level.factor, 0);
  EXPECT_FALSE(exact.factor || exact.levels[1].with_one_factor);
  // Of 40 rows, 4 are one standard deviation off: never a third of a half, mostly a tenth of it.
  for (int i = 0; i < 40; i += 10) rows[i].truth = 2;
  int positive = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const Calibration some = calibrate(rows, kLevels, seed);
    EXPECT_EQ(some.levels[0].factor, 0);
    if (some.levels[1].factor == 0) continue;
    EXPECT_NEAR(some.factor.value(), 1 / normal_half_width(0.9), 1e-12);
    ++positive;
  }
  EXPECT_GT(positive, 0);
}

}  // namespace
}  // namespace pliant
