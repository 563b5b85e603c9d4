#include "fitting/distribution/training_set.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Adds to the features of all samples, and sets groups of them to the average.
void disturb(std::span<float> features, const Disturbance& disturbance, Random& random) {
  std::array<float, kFeatures> offset{}, factor{};
  for (float& o : offset) o = static_cast<float>(disturbance.offset * random.normal());
  int c = 0;
  for (const int end : kFeatureGroups) {
    const float shown = random.uniform() < disturbance.hidden_groups ? 0.0f : 1.0f;
    for (; c < end; ++c) factor[c] = shown;
  }
  for (size_t i = 0; i < features.size(); ++i)
    features[i] = factor[i % kFeatures] * (features[i] + offset[i % kFeatures]);
}

}  // namespace

MaterialMeans means_of(const MaterialObject& o) {
  const size_t m = o.samples.size();
  CHECK(m > 0 && o.young.size() == m && o.poisson.size() == m && o.density.size() == m);
  double volume = 0, young = 0, poisson = 0, density = 0;
  for (size_t i = 0; i < m; ++i) {
    const double v = o.samples.volume[i];
    volume += v;
    young += v * o.young[i];
    poisson += v * o.poisson[i];
    density += v * o.density[i];
  }
  return {young / volume, poisson / volume, density / volume};
}

std::vector<float> targets_of(const MaterialObject& o, const MaterialMeans& means) {
  std::vector<float> out;
  for (size_t i = 0; i < o.samples.size(); ++i) {
    out.push_back(static_cast<float>(std::log10(o.young[i] / means.young)));
    out.push_back(static_cast<float>(std::log10(o.density[i] / means.density)));
    out.push_back(static_cast<float>(o.poisson[i] - means.poisson));
  }
  return out;
}

bool leaves_out(int members, int member, int family) {
  return members > 1 && family >= 0 && family % members == member;
}

TrainingSet make_training_set(const TrainingSetOptions& options, std::span<const std::string> families,
                              std::span<const MaterialObject> more) {
  CHECK(!families.empty() || options.objects == 0);
  const size_t count = options.objects + more.size();
  TrainingSet set;
  set.features.resize(count * kContextSamples * kFeatures);
  set.target.resize(count * kContextSamples * 3);
  set.family.assign(count, -1);
#pragma omp parallel for schedule(dynamic) num_threads(options.threads)
  for (size_t k = 0; k < count; ++k) {
    const bool own = k < static_cast<size_t>(options.objects);
    const MaterialObject o =
        own ? make_object(families[k % families.size()], options.seed + k) : more[k - options.objects];
    if (own) set.family[k] = static_cast<int>(k % families.size());
    const MaterialMeans means = means_of(o);
    Random random(options.seed, k, 1);
    FeatureInput input{o.samples, o.colour, o.part, o.up, {}};
    const double off = options.vague ? 0.15 * random.normal() : 0, band = options.vague ? random.uniform(0.3, 2.5) : 1;
    input.prior.typical = means.young * std::pow(10.0, off);
    input.prior.low = input.prior.typical * std::pow(10.0, -band / 2);
    input.prior.high = input.prior.typical * std::pow(10.0, band / 2);
    const std::vector<float> features = local_features(input), target = targets_of(o, means);
    for (size_t s = 0; s < kContextSamples; ++s) {
      const size_t from = s * o.samples.size() / kContextSamples, to = k * kContextSamples + s;
      std::copy_n(features.begin() + from * kFeatures, kFeatures, set.features.begin() + to * kFeatures);
      std::copy_n(target.begin() + from * 3, 3, set.target.begin() + to * 3);
    }
  }
  return set;
}

TrainingBatch batch_of(const DistributionNetwork& network, const TrainingSet& set, std::span<const int> objects,
                       int samples, const Disturbance& disturbance, uint64_t seed) {
  CHECK(samples <= kContextSamples);
  TrainingBatch batch{static_cast<int>(objects.size()), samples, {}, {}};
  std::vector<int> order(kContextSamples);
  for (const int object : objects) {
    Random random(seed, object);
    std::iota(order.begin(), order.end(), 0);
    for (int i = 0; i < samples && samples < kContextSamples; ++i)
      std::swap(order[i], order[i + random.below(kContextSamples - i)]);
    std::vector<float> features;
    const bool hide = random.uniform() < disturbance.hidden_parts;
    for (int i = 0; i < samples; ++i) {
      const size_t row = static_cast<size_t>(object) * kContextSamples + order[i];
      features.insert(features.end(), set.features.begin() + row * kFeatures,
                      set.features.begin() + (row + 1) * kFeatures);
      if (hide) std::fill_n(features.end() - kFeatures + kFirstPartFeature, kPartFeatures, 0.0f);
      batch.target.insert(batch.target.end(), set.target.begin() + row * 3, set.target.begin() + (row + 1) * 3);
    }
    std::vector<float> own = normalised(network, features);
    disturb(own, disturbance, random);
    batch.features.insert(batch.features.end(), own.begin(), own.end());
  }
  return batch;
}

}  // namespace pliant
