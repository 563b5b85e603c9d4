#include "fitting/distribution/calibrate.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

constexpr size_t kEvery = 4;  // samples that are looked at
constexpr double kInside = 0.8;

/// What members say of an object that they have not seen, and what is true.
struct Judged {
  std::vector<std::vector<float>> outputs;
  std::vector<float> z;
};

void add_judged(const TrainingSet& set, const DistributionNetwork& network, bool by_all, std::vector<Judged>& out) {
  const size_t features = static_cast<size_t>(kContextSamples) * kFeatures;
  const int members = static_cast<int>(network.members.size());
  for (size_t k = 0; k < set.objects(); ++k) {
    Judged judged;
    const auto own = normalised(network, std::span(set.features).subspan(k * features, features));
    for (int m = 0; m < members; ++m)
      if (by_all || leaves_out(members, m, set.family[k]))
        judged.outputs.push_back(network_outputs(network.size, network.members[m], own));
    if (judged.outputs.empty()) continue;
    for (size_t i = 0; i < kContextSamples; ++i) judged.z.push_back(set.target[3 * (k * kContextSamples + i)]);
    out.push_back(std::move(judged));
  }
}

/// Of the samples that are looked at: `of` their mixtures and true values.
template <class Of>
std::vector<double> over(const DistributionNetwork& network, const std::vector<Judged>& objects, const Of& of) {
  std::vector<double> out;
  for (const Judged& o : objects) {
    const auto mixtures = young_mixtures(network, o.outputs);
    for (size_t i = 0; i < mixtures.size(); i += kEvery) out.push_back(of(mixtures[i], o.z[i]));
  }
  return out;
}

}  // namespace

void calibrate(const TrainingSet& train, const TrainingSet& held, DistributionNetwork& network) {
  std::vector<Judged> objects;
  add_judged(held, network, true, objects);
  add_judged(train, network, false, objects);
  double best = -INFINITY;
  DistributionNetwork trial = network;
  for (const float wide : {0.02f, 0.05f, 0.1f, 0.2f}) {
    for (float temperature = 0.7f; temperature < 3.05f; temperature *= 1.1f) {
      trial.wide_weight = wide;
      trial.temperature = temperature;
      double sum = 0;
      for (const double value : over(trial, objects, [](const YoungMixture&m, double z) { return m.log_density(z); }))
        sum += value;
      if (sum <= best) continue;
      best = sum;
      network.wide_weight = wide;
      network.temperature = temperature;
    }
  }
  // The interval that holds so many of the values.
  std::vector<double> off =
      over(network, objects, [](const YoungMixture& m, double z) { return std::abs(m.below(z) - 0.5); });
  network.tail = static_cast<float>(std::clamp(0.5 - quantile(std::move(off), kInside), 0.01, 0.3));
}

}  // namespace pliant
