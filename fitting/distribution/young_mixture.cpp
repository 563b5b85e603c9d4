#include "fitting/distribution/young_mixture.h"

#include <algorithm>
#include <cmath>

namespace pliant {

double YoungMixture::log_density(double z) const {
  double sum = 0;
  for (const Gaussian& g : parts) {
    const double u = (z - g.mean) / g.sigma;
    sum += g.weight / g.sigma * std::exp(-0.5 * u * u);
  }
  return std::log(std::max(sum, 1e-300)) - 0.5 * std::log(2 * 3.14159265358979323846);
}

double YoungMixture::below(double z) const {
  double sum = 0;
  for (const Gaussian& g : parts) sum += g.weight * 0.5 * std::erfc((g.mean - z) / (g.sigma * std::sqrt(2.0)));
  return sum;
}

double YoungMixture::quantile(double share) const {
  double low = INFINITY, high = -INFINITY;
  for (const Gaussian& g : parts) {
    low = std::min(low, g.mean - 9 * g.sigma);
    high = std::max(high, g.mean + 9 * g.sigma);
  }
  // Newton's steps, halving where they leave what is left.
  double z = 0.5 * (low + high);
  while (high - low > 1e-9) {
    const double difference = below(z) - share;
    (difference < 0 ? low : high) = z;
    const double step = difference / std::exp(log_density(z));
    if (std::abs(step) < 1e-7) return z - step;
    z = z - step > low && z - step < high ? z - step : 0.5 * (low + high);
  }
  return z;
}

double YoungMixture::deviation() const {
  double mean = 0, square = 0;
  for (const Gaussian& g : parts) {
    mean += g.weight * g.mean;
    square += g.weight * (g.mean * g.mean + g.sigma * g.sigma);
  }
  return std::sqrt(std::max(0.0, square - mean * mean));
}

}  // namespace pliant
