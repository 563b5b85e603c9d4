#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/statistics/proportion.h"

namespace pliant {

struct BootstrapOptions {
  double level = 0.95;
  int resamples = 10000;
  uint64_t seed = 1;
};

/// A mean with a confidence interval, which is NaN where fewer than 2 clusters make it up, or too few without a spread.
struct MeanEstimate {
  double mean = 0;
  Interval interval;
  int values = 0, clusters = 0;
};

/// Mean of values that are independent only from cluster to cluster: `cluster` [N] numbers them (empty = each value is
/// its own).  Whole clusters are drawn with replacement (Efron and Tibshirani 1993, ch. 8).  The percentiles are
/// those of the expanded interval (Hesterberg 2015, section 5.3), which makes up for the few clusters: Phi(-t sqrt(n /
/// (n - 1))) with t of Student's distribution with n - 1 degrees of freedom.  Equal for equal seeds.  Resamples never
/// leave the range of the clusters, so that too few of them get Student's interval of a ratio of sums instead.
MeanEstimate bootstrap_mean(const BootstrapOptions& options, std::span<const double> values,
                            std::span<const int> cluster = {});

/// Whether clusters that all differ in one direction would do so by chance more often than 1 - level: 2^(1 - n), the
/// two-sided sign test.  Fewer than 6 at a level of 0.95.
bool too_few_clusters(int clusters, double level);

/// Mean of a[i] - b[i], drawn in pairs.
MeanEstimate bootstrap_difference(const BootstrapOptions& options, std::span<const double> a, std::span<const double> b,
                                  std::span<const int> cluster = {});

/// Numbers equal texts alike, in the order in which they first appear.
std::vector<int> cluster_numbers(std::span<const std::string> names);

}  // namespace pliant
