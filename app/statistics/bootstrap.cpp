#include "app/statistics/bootstrap.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

struct Cluster {
  double sum = 0;
  int count = 0;
};

double student_quantile(double level, double clusters) {
  return boost::math::quantile(boost::math::students_t_distribution<double>(clusters - 1), 0.5 * (1 + level));
}

/// Share of the resamples to leave out at each end.
double expanded_tail(double level, size_t clusters) {
  const auto n = static_cast<double>(clusters);
  const double t = student_quantile(level, n);
  return boost::math::cdf(boost::math::normal_distribution<double>(), -t * std::sqrt(n / (n - 1)));
}

/// Linear between the order statistics.
double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<size_t>(at);
  const size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

/// Of a mean over clusters, linearized as a ratio of their sums (Cochran 1977, ch. 6); NaN without a spread.
Interval student_interval(const std::vector<Cluster>& clusters, double mean, double level) {
  double squares = 0, count = 0;
  for (const Cluster& own : clusters) {
    squares += std::pow(own.sum - mean * own.count, 2);
    count += own.count;
  }
  const auto n = static_cast<double>(clusters.size());
  // Equal means differ by rounding.
  const bool spread = std::sqrt(squares) > 1e-12 * std::abs(mean) * count;
  const double half = spread ? student_quantile(level, n) * std::sqrt(n / (n - 1) * squares) / count
                             : std::numeric_limits<double>::quiet_NaN();
  return {mean - half, mean + half};
}

}  // namespace

bool too_few_clusters(int clusters, double level) { return std::exp2(1 - clusters) > 1 - level; }

MeanEstimate bootstrap_mean(const BootstrapOptions& options, std::span<const double> values,
                            std::span<const int> cluster) {
  CHECK(!values.empty() && (cluster.empty() || cluster.size() == values.size()));
  CHECK(options.level > 0 && options.level < 1 && options.resamples > 1);
  std::map<int, Cluster> by_number;
  double sum = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    Cluster& own = by_number[cluster.empty() ? static_cast<int>(i) : cluster[i]];
    own.sum += values[i];
    ++own.count;
    sum += values[i];
  }
  std::vector<Cluster> clusters;
  for (const auto& [number, own] : by_number) clusters.push_back(own);
  MeanEstimate out;
  out.values = static_cast<int>(values.size());
  out.clusters = static_cast<int>(clusters.size());
  out.mean = sum / static_cast<double>(values.size());
  if (clusters.size() < 2) {
    out.interval.low = out.interval.high = std::numeric_limits<double>::quiet_NaN();
    return out;
  }
  if (too_few_clusters(out.clusters, options.level)) {
    out.interval = student_interval(clusters, out.mean, options.level);
    return out;
  }
  std::vector<double> means(options.resamples);
  for (int b = 0; b < options.resamples; ++b) {
    Random random(options.seed, b);
    Cluster drawn;
    for (size_t k = 0; k < clusters.size(); ++k) {
      const Cluster& own = clusters[random.below(clusters.size())];
      drawn.sum += own.sum;
      drawn.count += own.count;
    }
    means[b] = drawn.sum / drawn.count;
  }
  std::sort(means.begin(), means.end());
  const double tail = expanded_tail(options.level, clusters.size());
  out.interval = {quantile(means, tail), quantile(means, 1 - tail)};
  return out;
}

MeanEstimate bootstrap_difference(const BootstrapOptions& options, std::span<const double> a, std::span<const double> b,
                                  std::span<const int> cluster) {
  CHECK(a.size() == b.size());
  std::vector<double> difference;
  for (size_t i = 0; i < a.size(); ++i) difference.push_back(a[i] - b[i]);
  return bootstrap_mean(options, difference, cluster);
}

std::vector<int> cluster_numbers(std::span<const std::string> names) {
  std::map<std::string, int> numbers;
  std::vector<int> out;
  for (const std::string& name : names)
    out.push_back(numbers.emplace(name, static_cast<int>(numbers.size())).first->second);
  return out;
}

}  // namespace pliant
