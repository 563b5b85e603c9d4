#include "app/statistics/proportion.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"

namespace pliant {
namespace {

void check_counts(int successes, int trials) { CHECK(trials > 0 && successes >= 0 && successes <= trials); }
void check_level(double level) { CHECK(level > 0 && level < 1); }

}  // namespace

Interval clopper_pearson(int successes, int trials, double level) {
  check_counts(successes, trials);
  check_level(level);
  using Binomial = boost::math::binomial_distribution<double>;
  const double tail = 0.5 * (1 - level);
  return {Binomial::find_lower_bound_on_p(trials, successes, tail),
          Binomial::find_upper_bound_on_p(trials, successes, tail)};
}

Interval wilson(int successes, int trials, double level) {
  check_counts(successes, trials);
  check_level(level);
  const double n = trials, p = successes / n;
  const double z = boost::math::quantile(boost::math::normal_distribution<double>(), 0.5 * (1 + level));
  const double shrink = 1 / (1 + z * z / n), centre = shrink * (p + z * z / (2 * n)),
               half = shrink * z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

double binomial_test(int successes, int trials, double p0) {
  check_counts(successes, trials);
  CHECK(p0 >= 0 && p0 <= 1);
  const boost::math::binomial_distribution<double> outcomes(trials, p0);
  // Outcomes that are equally likely in exact arithmetic differ by rounding.
  const double limit = boost::math::pdf(outcomes, successes) * (1 + 1e-7);
  double sum = 0;
  for (int k = 0; k <= trials; ++k) {
    const double likely = boost::math::pdf(outcomes, k);
    if (likely <= limit) sum += likely;
  }
  return std::min(1.0, sum);
}

std::vector<double> holm_adjusted(std::span<const double> p_values) {
  const size_t n = p_values.size();
  std::vector<size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(n);
  double largest = 0;
  for (size_t rank = 0; rank < n; ++rank) {
    largest = std::max(largest, std::min(1.0, static_cast<double>(n - rank) * p_values[order[rank]]));
    adjusted[order[rank]] = largest;
  }
  return adjusted;
}

}  // namespace pliant
