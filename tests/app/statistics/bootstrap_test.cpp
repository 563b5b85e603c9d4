// Bootstrap intervals against Student's and in simulation, where the mean is known.

#include "app/statistics/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

TEST(BootstrapMean, OfManyNormalValuesItIsStudentsInterval) {
  std::vector<double> values;
  double mean = 0, square = 0;
  for (int i = 0; i < 40; ++i) values.push_back(3 + Random(4, i).normal());
  for (const double v : values) mean += v / 40;
  for (const double v : values) square += (v - mean) * (v - mean) / 39;
  const double half = 2.0227 * std::sqrt(square / 40);
  const MeanEstimate found = bootstrap_mean({}, values);
  EXPECT_NEAR(found.mean, mean, 1e-12);
  EXPECT_NEAR(found.interval.low, mean - half, 0.1 * half);
  EXPECT_NEAR(found.interval.high, mean + half, 0.1 * half);
  EXPECT_EQ(found.clusters, 40);
}

TEST(BootstrapMean, OfEqualValuesTheIntervalIsAPoint) {
  const MeanEstimate found = bootstrap_mean({}, std::vector<double>(6, 2.5));
  EXPECT_EQ(found.interval.low, 2.5);
  EXPECT_EQ(found.interval.high, 2.5);
}

TEST(BootstrapMean, OfTooFewClustersItIsStudentsInterval) {
  EXPECT_TRUE(too_few_clusters(5, 0.95));
  EXPECT_FALSE(too_few_clusters(6, 0.95));
  const std::vector<double> values = {1, 2, 4, 5};
  const double half = 3.18245 * std::sqrt(10.0 / 3 / 4);
  const MeanEstimate found = bootstrap_mean({}, values);
  EXPECT_NEAR(found.interval.low, 3 - half, 1e-4);
  EXPECT_NEAR(found.interval.high, 3 + half, 1e-4);
  // Each cluster twice is the same four.
  const std::vector<double> twice = {1, 1, 2, 2, 4, 4, 5, 5};
  const std::vector<int> cluster = {0, 0, 1, 1, 2, 2, 3, 3};
  EXPECT_NEAR(bootstrap_mean({}, twice, cluster).interval.low, found.interval.low, 1e-12);
  const MeanEstimate equal = bootstrap_mean({}, std::vector<double>(4, 0.3));
  EXPECT_TRUE(std::isnan(equal.interval.low) && std::isnan(equal.interval.high)) << "no spread is known";
}

TEST(BootstrapMean, OneClusterSaysNothingAboutTheSpread) {
  const std::vector<double> values = {1, 2, 3};
  const std::vector<int> cluster = {7, 7, 7};
  const MeanEstimate found = bootstrap_mean({}, values, cluster);
  EXPECT_EQ(found.mean, 2);
  EXPECT_TRUE(std::isnan(found.interval.low) && std::isnan(found.interval.high));
}

TEST(BootstrapMean, EqualSeedsGiveEqualIntervals) {
  const std::vector<double> values = {1, 5, 2, 8, 4, 3};
  BootstrapOptions other;
  other.seed = 2;
  EXPECT_EQ(bootstrap_mean({}, values).interval.low, bootstrap_mean({}, values).interval.low);
  EXPECT_NE(bootstrap_mean({}, values).interval.high, bootstrap_mean(other, values).interval.high + 1e-9);
}

/// Share of repetitions in which the interval holds the mean 0 of `clusters` clusters of `each` values.
double coverage_of(int clusters, int each, double between, bool clustered, double skew) {
  int inside = 0;
  const int repetitions = 500;
  for (int r = 0; r < repetitions; ++r) {
    std::vector<double> values;
    std::vector<int> cluster;
    Random random(11, r);
    for (int k = 0; k < clusters; ++k) {
      const double z = random.normal(), shift = between * (z + skew * (z * z - 1));
      for (int i = 0; i < each; ++i) {
        values.push_back(shift + random.normal());
        cluster.push_back(k);
      }
    }
    BootstrapOptions options;
    options.resamples = 600;
    options.seed = r + 1;
    const MeanEstimate found =
        bootstrap_mean(options, values, clustered ? std::span<const int>(cluster) : std::span<const int>());
    inside += found.interval.contains(0);
  }
  return static_cast<double>(inside) / repetitions;
}

TEST(BootstrapMean, CoversTheMeanAsOftenAsStated) {
  // The standard error of 500 repetitions is 0.01.
  EXPECT_NEAR(coverage_of(8, 1, 0.0, true, 0), 0.95, 0.03);
  EXPECT_NEAR(coverage_of(25, 1, 0.0, true, 0), 0.95, 0.03);
  EXPECT_NEAR(coverage_of(12, 6, 1.5, true, 0), 0.95, 0.03);
  EXPECT_NEAR(coverage_of(25, 4, 1.0, true, 0.3), 0.95, 0.04);
}

TEST(BootstrapMean, ValuesThatAreNotIndependentNeedTheirClusters) {
  EXPECT_LT(coverage_of(12, 6, 1.5, false, 0), 0.75);
}

TEST(BootstrapDifference, PairsCancelWhatTheyShare) {
  std::vector<double> a, b;
  for (int i = 0; i < 20; ++i) {
    const double scene = 10 * Random(5, i).normal();
    b.push_back(scene);
    a.push_back(scene + 0.5 + 0.1 * Random(6, i).normal());
  }
  const MeanEstimate found = bootstrap_difference({}, a, b);
  EXPECT_TRUE(found.interval.contains(0.5));
  EXPECT_LT(found.interval.high - found.interval.low, 0.2);
}

}  // namespace
}  // namespace pliant
