// Intervals and tests of proportions against closed forms, and their coverage summed over all outcomes.

#include "app/statistics/proportion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pliant {
namespace {

double binomial_pmf(int k, int n, double p) {
  return std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(p) +
                  (n - k) * std::log1p(-p));
}

/// Probability that the interval holds p.
template <class F>
double coverage_of(F&& interval, int n, double p) {
  double sum = 0;
  for (int k = 0; k <= n; ++k)
    if (interval(k, n, 0.95).contains(p)) sum += binomial_pmf(k, n, p);
  return sum;
}

TEST(ClopperPearson, WithoutAnySuccessOrFailureTheBoundIsARoot) {
  for (const int n : {1, 5, 40}) {
    EXPECT_EQ(clopper_pearson(0, n).low, 0);
    EXPECT_NEAR(clopper_pearson(0, n).high, 1 - std::pow(0.025, 1.0 / n), 1e-12);
    EXPECT_NEAR(clopper_pearson(n, n, 0.9).low, std::pow(0.05, 1.0 / n), 1e-12);
    EXPECT_EQ(clopper_pearson(n, n).high, 1);
  }
}

TEST(ClopperPearson, BoundsLeaveHalfTheRestInEachTail) {
  const Interval found = clopper_pearson(7, 20, 0.9);
  double above = 0, below = 0;
  for (int k = 7; k <= 20; ++k) above += binomial_pmf(k, 20, found.low);
  for (int k = 0; k <= 7; ++k) below += binomial_pmf(k, 20, found.high);
  EXPECT_NEAR(above, 0.05, 1e-10);
  EXPECT_NEAR(below, 0.05, 1e-10);
}

TEST(ClopperPearson, CoversAtLeastAsOftenAsStated) {
  for (int i = 1; i < 200; ++i) EXPECT_GE(coverage_of(clopper_pearson, 23, i / 200.0), 0.95 - 1e-12);
}

TEST(Wilson, PublishedValuesAndAverageCoverage) {
  EXPECT_NEAR(wilson(60, 100).low, 0.502, 5e-4);
  EXPECT_NEAR(wilson(60, 100).high, 0.691, 5e-4);
  EXPECT_NEAR(wilson(8, 10).low, 0.490, 5e-4);
  EXPECT_NEAR(wilson(8, 10).high, 0.943, 5e-4);
  // The bounds are where the score test rejects: (p - k / n)^2 = z^2 p (1 - p) / n.
  const double p = wilson(3, 12).low;
  EXPECT_NEAR(std::pow(p - 0.25, 2) / (p * (1 - p) / 12), std::pow(1.959963984540054, 2), 1e-9);
  double mean = 0;
  for (int i = 1; i < 200; ++i) mean += coverage_of(wilson, 40, i / 200.0) / 199;
  EXPECT_NEAR(mean, 0.95, 0.01);
}

TEST(BinomialTest, SumsOutcomesThatAreNoMoreLikely) {
  EXPECT_NEAR(binomial_test(8, 10), 2 * (45 + 10 + 1) / 1024.0, 1e-12);
  EXPECT_NEAR(binomial_test(5, 10), 1, 1e-12);
  // p0 = 1/4 of 4: 81, 108, 54, 12, 1 of 256; 3 successes and more.
  EXPECT_NEAR(binomial_test(3, 4, 0.25), 13 / 256.0, 1e-12);
  EXPECT_NEAR(binomial_test(0, 4, 0.25), (81 + 54 + 12 + 1) / 256.0, 1e-12);
}

TEST(BinomialTest, RejectsATrueHypothesisNoMoreOftenThanItsLevel) {
  for (const double p : {0.5, 0.37}) {
    double rejected = 0;
    for (int k = 0; k <= 60; ++k)
      if (binomial_test(k, 60, p) <= 0.05) rejected += binomial_pmf(k, 60, p);
    EXPECT_LE(rejected, 0.05);
    EXPECT_GT(rejected, 0.02);
  }
}

TEST(HolmAdjusted, StepsDownAndKeepsTheOrder) {
  const std::vector<double> p = {0.04, 0.01, 0.03, 0.5};
  const std::vector<double> adjusted = holm_adjusted(p), expected = {0.09, 0.04, 0.09, 0.5};
  for (size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(adjusted[i], expected[i], 1e-12);
}

}  // namespace
}  // namespace pliant
