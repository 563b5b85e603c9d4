#include "fitting/fit/correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

TEST(CorrelationFactor, IsOneForWhiteNoiseAndThatOfAnAutoregressionOtherwise) {
  // x_k = a x_(k-1) + noise has autocorrelations a^lag: factor (1 + a) / (1 - a) = 3.
  std::vector<double> white, slow(2);
  for (int k = 0; k < 20000; ++k) {
    for (int c = 0; c < 2; ++c) {
      white.push_back(Random(k, c).normal());
      slow.push_back(0.5 * slow[slow.size() - 2] + white.back());
    }
  }
  EXPECT_NEAR(correlation_factor(white, 2), 1, 0.1);
  EXPECT_NEAR(correlation_factor(slow, 2), 3, 0.4);
}

constexpr size_t kPoints = 300, kRows = 60;

std::vector<Vec3f> on_a_line(size_t count) {
  std::vector<Vec3f> place;
  for (size_t k = 0; k < count; ++k) place.push_back(Vec3d(0.01 * static_cast<double>(k), 0, 0).cast<float>());
  return place;
}

/// [rows, points, 2] of unit variance: the mean of `width` neighbouring values, which has factor `width`, with an
/// autoregression a in time, which has factor (1 + a) / (1 - a).
std::vector<double> noise(size_t width, double a, uint64_t seed) {
  std::vector<double> out;
  for (size_t t = 0; t < kRows; ++t)
    for (size_t k = 0; k < kPoints; ++k)
      for (size_t c = 0; c < 2; ++c) {
        double sum = 0;
        for (size_t j = 0; j < width; ++j) sum += Random(seed + 2 * t + c, k + j).normal() / std::sqrt(static_cast<double>(width));
        out.push_back(t == 0 ? sum : a * out[out.size() - 2 * kPoints] + std::sqrt(1 - a * a) * sum);
      }
  return out;
}

TEST(CorrelationFactor, OfPointsIsOneForWhiteNoiseAndTheProductWhereTimeAndSpaceAreApart) {
  const std::vector<Vec3f> place = on_a_line(kPoints);
  EXPECT_NEAR(correlation_factor(noise(1, 0, 1), place, 2), 1, 0.1);
  EXPECT_NEAR(correlation_factor(noise(2, 0, 1), place, 2), 2, 0.2);
  EXPECT_NEAR(correlation_factor(noise(4, 0, 1), place, 2), 4, 0.4);
  EXPECT_NEAR(correlation_factor(noise(1, 0.5, 1), place, 2), 3, 0.4);
  EXPECT_NEAR(correlation_factor(noise(2, 0.5, 1), place, 2), 6, 0.9);
}

TEST(CorrelationFactor, OfASumIsTheMeanOfBothNotAProduct) {
  // One part lasts and is each point's own, one is shared by four neighbours and gone with the row: (3 + 4) / 2.
  std::vector<double> sum = noise(1, 0.5, 1);
  const std::vector<double> other = noise(4, 0, 1000);
  for (size_t k = 0; k < sum.size(); ++k) sum[k] += other[k];
  EXPECT_NEAR(correlation_factor(sum, on_a_line(kPoints), 2), 3.5, 0.4);
}

TEST(CorrelationFactor, IsThatOfAllPointsWhereOnlySomeAreLookedAt) {
  // 3000 points with errors that 60 in a row have in common.
  constexpr size_t kMany = 3000;
  std::vector<double> residuals;
  for (size_t t = 0; t < 100; ++t)
    for (size_t k = 0; k < kMany; ++k) {
      double sum = 0;
      for (size_t j = 0; j < 60; ++j) sum += Random(t, k + j).normal();
      residuals.push_back(sum);
    }
  EXPECT_NEAR(correlation_factor(residuals, on_a_line(kMany), 1), 60, 9);
}

TEST(CorrelationFactor, PointsWithoutErrorsHaveNoSay) {
  EXPECT_EQ(correlation_factor(std::vector<double>(30, 0.0), on_a_line(3), 1), 1);
  EXPECT_EQ(correlation_factor(std::vector<double>{1, 0, 0}, on_a_line(3), 1), 1);
}

TEST(Unexplained, OfWhiteErrorsIsTheirRootMeanSquareOfSharedOnesWider) {
  const std::vector<Vec3f> place = on_a_line(kPoints);
  EXPECT_NEAR(unexplained(noise(1, 0, 1), place, 2), 1, 0.05);
  EXPECT_NEAR(unexplained(noise(4, 0, 1), place, 2), 2, 0.1);
}

}  // namespace
}  // namespace pliant
