#include "fitting/distribution/object_distribution.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/nearest.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr size_t kMostAnchors = 2000;    // samples over which means are taken
constexpr float kReach = 3;              // spacings of the anchors
constexpr float kLikeColour = 0.15f;     // distance in sRGB
constexpr float kLikeThickness = 0.25f;  // decades
constexpr int kQuantities = 6;

/// What is averaged: E and its interval as decades, deviation, nu, decades of rho.
std::array<double, kQuantities> quantities_of(const MaterialDistribution& d, size_t i) {
  return {std::log10(d.young[i]), std::log10(d.young_low[i]), std::log10(d.young_high[i]), d.sigma[i],
          d.poisson[i],           std::log10(d.density[i])};
}

/// Median distance of a sample of `places` to its nearest other one.
float spacing_of(const std::vector<Vec3f>& places, const NearestPoints& tree) {
  std::vector<float> nearest;
  std::vector<NearestPoints::Hit> hits;
  for (const Vec3f& x : places) {
    tree.query(x, 2, hits);
    nearest.push_back((places[hits.back().index] - x).norm());
  }
  return std::max(quantile(std::move(nearest), 0.5), 1e-9f);
}

/// Volume-weighted mean of value(i) over all samples.
template <class Value>
double mean_over(std::span<const float> volume, const Value& value) {
  double sum = 0, total = 0;
  for (size_t i = 0; i < volume.size(); ++i) {
    sum += double{volume[i]} * value(i);
    total += volume[i];
  }
  return sum / total;
}

/// Factor that gives `values` the volume-weighted mean `wanted`.
double factor_to_mean(std::span<const float> values, std::span<const float> volume, double wanted) {
  return wanted / mean_over(volume, [&](size_t i) { return values[i]; });
}

/// Shifts nu to the volume-weighted mean `wanted`, within poisson_range.
void shift_poisson(std::vector<float>& poisson, std::span<const float> volume, double wanted) {
  const auto [lowest, highest] = poisson_range(wanted);
  double low = -2, high = 2;  // more than nu can differ by
  const auto shifted = [&, lowest = lowest, highest = highest](size_t i, double shift) {
    return std::clamp(poisson[i] + shift, lowest, highest);
  };
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    (mean_over(volume, [&](size_t i) { return shifted(i, middle); }) > wanted ? high : low) = middle;
  }
  for (size_t i = 0; i < poisson.size(); ++i) poisson[i] = static_cast<float>(shifted(i, low));
}

void scale(std::vector<float>& values, double factor) {
  for (float& v : values) v = static_cast<float>(v * factor);
}

}  // namespace

void average_over_neighbours(const FeatureInput& object, MaterialDistribution& d) {
  const SolidSamples& samples = object.samples;
  const size_t m = samples.size(), n = std::min(m, kMostAnchors);
  std::vector<size_t> anchor(n);
  std::vector<Vec3f> places(n);
  std::vector<std::array<double, kQuantities>> values(n);
  for (size_t a = 0; a < n; ++a) {
    anchor[a] = a * m / n;
    places[a] = samples.position[anchor[a]];
    values[a] = quantities_of(d, anchor[a]);
  }
  const auto thickness = [&](size_t i) {
    return i < samples.thickness.size() && samples.thickness[i] > 0 ? std::log10(samples.thickness[i]) : 0.0f;
  };
  const NearestPoints tree(places);
  const float reach = kReach * spacing_of(places, tree);
  parallel_for(
      static_cast<std::ptrdiff_t>(m),
      [&](std::ptrdiff_t i) {
        // The sample itself counts too, as one that is alone of its kind keeps what it has.
        std::array<double, kQuantities> sum = quantities_of(d, i);
        double total = 1;
        std::vector<NearestPoints::Hit> hits;
        tree.around(samples.position[i], 2 * reach, hits);
        for (const auto& hit : hits) {
          const size_t j = anchor[hit.index];
          const float far = (samples.position[j] - samples.position[i]).norm() / reach;
          const float colour = (object.colour[j] - object.colour[i]).norm() / kLikeColour;
          const float thick = (thickness(j) - thickness(i)) / kLikeThickness;
          const double weight = std::exp(-0.5 * double{far * far + colour * colour + thick * thick});
          for (int q = 0; q < kQuantities; ++q) sum[q] += weight * values[hit.index][q];
          total += weight;
        }
        for (double& s : sum) s /= total;
        d.young[i] = static_cast<float>(std::pow(10.0, sum[0]));
        d.young_low[i] = static_cast<float>(std::pow(10.0, sum[1]));
        d.young_high[i] = static_cast<float>(std::pow(10.0, sum[2]));
        d.sigma[i] = static_cast<float>(sum[3]);
        d.poisson[i] = static_cast<float>(sum[4]);
        d.density[i] = static_cast<float>(std::pow(10.0, sum[5]));
      },
      64);
}

MaterialDistribution object_distribution(const DistributionNetwork& network, const FeatureInput& object,
                                         std::span<const float> volume, const MaterialMeans& means) {
  CHECK(volume.size() == object.samples.size());
  MaterialDistribution d = predict_distribution(network, local_features(object), volume, means);
  average_over_neighbours(object, d);
  const double young = factor_to_mean(d.young, volume, means.young);
  for (auto* values : {&d.young, &d.young_low, &d.young_high}) scale(*values, young);
  scale(d.density, factor_to_mean(d.density, volume, means.density));
  shift_poisson(d.poisson, volume, means.poisson);
  return d;
}

}  // namespace pliant
