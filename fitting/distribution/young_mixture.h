#pragma once

#include <vector>

namespace pliant {

/// Distribution of z = log10(E / mean E) at one sample: Gaussians whose weights sum to 1.
struct YoungMixture {
  struct Gaussian {
    double weight, mean, sigma;
  };
  std::vector<Gaussian> parts;

  double log_density(double z) const;   ///< natural logarithm, per decade
  double below(double z) const;         ///< probability of less than z
  double quantile(double share) const;  ///< inverse of below, share in (0, 1)
  double deviation() const;             ///< standard deviation
};

}  // namespace pliant
