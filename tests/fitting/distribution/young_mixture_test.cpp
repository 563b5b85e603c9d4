#include "fitting/distribution/young_mixture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

YoungMixture one(double mean, double sigma) { return {{{1, mean, sigma}}}; }

YoungMixture any(uint64_t seed) {
  Random random(seed);
  YoungMixture m;
  double sum = 0;
  for (int k = 0; k < 5; ++k) {
    m.parts.push_back({random.uniform(0.05, 1), random.uniform(-3, 1), random.uniform(0.05, 1.5)});
    sum += m.parts.back().weight;
  }
  for (auto& g : m.parts) g.weight /= sum;
  return m;
}

TEST(YoungMixture, OfOneGaussianHasItsClosedForms) {
  const YoungMixture m = one(-0.7, 0.4);
  EXPECT_NEAR(m.log_density(-0.7), -std::log(0.4 * std::sqrt(2 * M_PI)), 1e-12);
  EXPECT_NEAR(m.log_density(-0.3), m.log_density(-0.7) - 0.5, 1e-12);
  EXPECT_NEAR(m.below(-0.7), 0.5, 1e-12);
  EXPECT_NEAR(m.deviation(), 0.4, 1e-12);
  EXPECT_NEAR(m.quantile(0.9), -0.7 + 0.4 * 1.2815515655446004, 1e-6);
  EXPECT_NEAR(m.quantile(0.1), -0.7 - 0.4 * 1.2815515655446004, 1e-6);
}

TEST(YoungMixture, QuantileIsTheInverseOfBelowAndBelowTheIntegralOfTheDensity) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const YoungMixture m = any(seed);
    for (const double share : {0.001, 0.1, 0.37, 0.5, 0.9, 0.999}) EXPECT_NEAR(m.below(m.quantile(share)), share, 1e-5);
    double sum = 0, mean = 0, square = 0;
    const double from = -16, step = 1e-3;
    for (int i = 0; i < 26000; ++i) {
      const double z = from + (i + 0.5) * step, p = step * std::exp(m.log_density(z));
      sum += p;
      mean += p * z;
      square += p * z * z;
    }
    EXPECT_NEAR(sum, m.below(10) - m.below(-16), 1e-4);
    EXPECT_NEAR(m.deviation(), std::sqrt(square - mean * mean), 1e-4);
    const double h = 1e-5;
    EXPECT_NEAR((m.below(0.3 + h) - m.below(0.3 - h)) / (2 * h), std::exp(m.log_density(0.3)), 1e-5);
  }
}

}  // namespace
}  // namespace pliant
