#pragma once

#include <span>
#include <vector>

namespace pliant {

/// Bounds of a confidence interval.
struct Interval {
  double low = 0, high = 0;
  bool contains(double x) const { return low <= x && x <= high; }
};

/// `successes` of `trials` > 0 independent trials.  Intervals of their probability at a confidence level in (0, 1):
/// exact, which covers at least as often as stated (Clopper and Pearson 1934), and by inverting the score test, which
/// covers as often on average (Wilson 1927).
Interval clopper_pearson(int successes, int trials, double level = 0.95);
Interval wilson(int successes, int trials, double level = 0.95);

/// Exact two-sided p-value of the hypothesis that the probability is `p0`: the probability of all outcomes that are no
/// more likely than this one.
double binomial_test(int successes, int trials, double p0 = 0.5);

/// p-values of several hypotheses, each adjusted so that the probability of any false rejection stays at the level
/// (Holm 1979); in the order given.
std::vector<double> holm_adjusted(std::span<const double> p_values);

}  // namespace pliant
