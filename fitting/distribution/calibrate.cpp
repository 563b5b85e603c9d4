#include "fitting/distribution/calibrate.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr size_t kEvery = 4;  // samples that are looked at
constexpr double kInside = 0.8;

/// Of the samples that are looked at: what the set's values are under the mixtures.
template <class Of>
std::vector<double> over(const DistributionNetwork& network, const TrainingSet& set,
                         std::span<const std::vector<float>> outputs, const Of& of) {
  const auto mixtures = young_mixtures(network, outputs);
  std::vector<double> out;
  for (size_t i = 0; i < mixtures.size(); i += kEvery) out.push_back(of(mixtures[i], set.target[3 * i]));
  return out;
}

}  // namespace

void calibrate(const TrainingSet& set, DistributionNetwork& network) {
  const std::vector<float> features = normalised(network, set.features);
  const size_t each = static_cast<size_t>(kContextSamples) * kFeatures;
  std::vector<std::vector<float>> outputs(network.members.size());
  for (size_t k = 0; k < set.objects(); ++k) {
    const auto own = member_outputs(network, std::span(features).subspan(k * each, each));
    for (size_t m = 0; m < own.size(); ++m) outputs[m].insert(outputs[m].end(), own[m].begin(), own[m].end());
  }
  double best = -INFINITY;
  DistributionNetwork trial = network;
  for (const float wide : {0.02f, 0.05f, 0.1f, 0.2f}) {
    for (float temperature = 0.7f; temperature < 3.05f; temperature *= 1.08f) {
      trial.wide_weight = wide;
      trial.temperature = temperature;
      double sum = 0;
      for (const double value :
           over(trial, set, outputs, [](const YoungMixture&m, double z) { return m.log_density(z); }))
        sum += value;
      if (sum <= best) continue;
      best = sum;
      network.wide_weight = wide;
      network.temperature = temperature;
    }
  }
  // The interval that holds so many of the values.
  std::vector<double> off =
      over(network, set, outputs, [](const YoungMixture& m, double z) { return std::abs(m.below(z) - 0.5); });
  const auto at = off.begin() + static_cast<std::ptrdiff_t>(kInside * static_cast<double>(off.size()));
  std::nth_element(off.begin(), at, off.end());
  network.tail = static_cast<float>(std::clamp(0.5 - *at, 0.01, 0.3));
}

}  // namespace pliant
