#include "fitting/fit/correlation.h"

#include <gtest/gtest.h>

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

TEST(NeighbourFactor, IsOneForWhiteNoiseAndThatOfAMovingAverageOtherwise) {
  // Points on a line, errors along two axes: e_k = w_k + w_(k+1) has correlation 1/2 with both neighbours, factor 2; the
  // mean of four, 3/4, 1/2 and 1/4: factor 4.
  constexpr size_t kPoints = 300, kRows = 40;
  std::vector<Vec3f> place;
  for (size_t k = 0; k < kPoints; ++k) place.push_back(Vec3d(0.01 * static_cast<double>(k), 0, 0).cast<float>());
  for (const size_t width : {1, 2, 4}) {
    std::vector<double> residuals;
    for (size_t t = 0; t < kRows; ++t)
      for (size_t k = 0; k < kPoints; ++k)
        for (size_t a = 0; a < 2; ++a) {
          double sum = 0;
          for (size_t j = 0; j < width; ++j) sum += Random(2 * t + a, k + j).normal();
          residuals.push_back(sum);
        }
    EXPECT_NEAR(neighbour_factor(residuals, place, 2), static_cast<double>(width), 0.1 * static_cast<double>(width)) << width;
  }
}

TEST(NeighbourFactor, IsThatOfAllPointsWhereOnlySomeAreLookedAt) {
  // 3000 points, every third of which is looked at, with errors that 60 in a row have in common.
  constexpr size_t kPoints = 3000, kRows = 20;
  std::vector<Vec3f> place;
  std::vector<double> residuals;
  for (size_t k = 0; k < kPoints; ++k) place.push_back(Vec3d(0.01 * static_cast<double>(k), 0, 0).cast<float>());
  for (size_t t = 0; t < kRows; ++t)
    for (size_t k = 0; k < kPoints; ++k) {
      double sum = 0;
      for (size_t j = 0; j < 60; ++j) sum += Random(t, k + j).normal();
      residuals.push_back(sum);
    }
  EXPECT_NEAR(neighbour_factor(residuals, place, 1), 60, 9);
}

TEST(NeighbourFactor, PointsWithoutErrorsHaveNoSay) {
  const std::vector<Vec3f> place = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 0, 0)};
  EXPECT_EQ(neighbour_factor(std::vector<double>(30, 0.0), place, 1), 1);
  EXPECT_EQ(neighbour_factor(std::vector<double>{1, 0, 0}, place, 1), 1);
}

}  // namespace
}  // namespace pliant
