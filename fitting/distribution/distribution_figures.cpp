#include "fitting/distribution/distribution_figures.h"

#include <algorithm>
#include <cmath>

#include "fitting/distribution/object_distribution.h"
#include "fitting/distribution/training_set.h"
#include "gaussians/base/error.h"
#include "gaussians/base/quantile.h"

namespace pliant {
namespace {

/// What the samples of one or several objects have: errors, and sums.
struct Tally {
  std::string family;
  size_t objects = 0;
  std::vector<double> error, error_of_mean, density, density_of_mean, poisson, poisson_of_mean;
  double log_density = 0, log_density_of_one = 0, inside = 0;

  void add(const Tally& t) {
    objects += t.objects;
    for (const auto part : {&Tally::error, &Tally::error_of_mean, &Tally::density, &Tally::density_of_mean,
                            &Tally::poisson, &Tally::poisson_of_mean})
      (this->*part).insert((this->*part).end(), (t.*part).begin(), (t.*part).end());
    log_density += t.log_density;
    log_density_of_one += t.log_density_of_one;
    inside += t.inside;
  }
};

Tally tally_of(const DistributionNetwork& network, const MaterialObject& o) {
  const MaterialMeans means = means_of(o);
  const YoungPrior prior{means.young / std::sqrt(10.0), means.young, means.young * std::sqrt(10.0)};
  const FeatureInput object{o.samples, o.colour, o.part, o.up, prior};
  const MaterialDistribution found = object_distribution(network, object, o.samples.volume, means);
  const auto mixtures = young_mixtures(network, member_outputs(network, normalised(network, local_features(object))));
  const YoungMixture one{{{1, network.wide_mean, network.wide_sigma}}};
  Tally t{o.family, 1, {}, {}, {}, {}, {}, {}};
  for (size_t i = 0; i < o.samples.size(); ++i) {
    const double z = std::log10(o.young[i] / means.young);
    t.error.push_back(std::abs(std::log10(o.young[i] / found.young[i])));
    t.error_of_mean.push_back(std::abs(z));
    t.density.push_back(std::abs(std::log10(o.density[i] / found.density[i])));
    t.density_of_mean.push_back(std::abs(std::log10(o.density[i] / means.density)));
    t.poisson.push_back(std::abs(o.poisson[i] - found.poisson[i]));
    t.poisson_of_mean.push_back(std::abs(o.poisson[i] - means.poisson));
    t.log_density += mixtures[i].log_density(z);
    t.log_density_of_one += one.log_density(z);
    t.inside += o.young[i] >= found.young_low[i] && o.young[i] <= found.young_high[i];
  }
  return t;
}

DistributionFigures figures_of(const Tally& t) {
  const double n = static_cast<double>(t.error.size());
  return {t.family,
          t.objects,
          t.error.size(),
          quantile(t.error, 0.5),
          quantile(t.error_of_mean, 0.5),
          t.log_density / n,
          t.log_density_of_one / n,
          t.inside / n,
          quantile(t.density, 0.5),
          quantile(t.density_of_mean, 0.5),
          quantile(t.poisson, 0.5),
          quantile(t.poisson_of_mean, 0.5)};
}

}  // namespace

std::vector<DistributionFigures> distribution_figures(const DistributionNetwork& network,
                                                      std::span<const MaterialObject> objects) {
  std::vector<Tally> families;
  Tally all;
  all.family = "all";
  for (const MaterialObject& o : objects) {
    const Tally own = tally_of(network, o);
    auto found = std::find_if(families.begin(), families.end(), [&](const Tally& t) { return t.family == o.family; });
    if (found == families.end()) {
      families.emplace_back().family = o.family;
      found = families.end() - 1;
    }
    found->add(own);
    all.add(own);
  }
  std::vector<DistributionFigures> out;
  for (const Tally& t : families) out.push_back(figures_of(t));
  if (!families.empty()) out.push_back(figures_of(all));
  return out;
}

}  // namespace pliant
