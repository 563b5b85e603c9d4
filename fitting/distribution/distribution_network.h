#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fitting/distribution/local_features.h"
#include "fitting/distribution/young_mixture.h"
#include "gaussians/base/types.h"

namespace pliant {

/// Widths of the network.  Per sample two layers; mean and maximum over the samples, joined to every sample; a layer;
/// mean and maximum once more; a layer; the heads (sets: Zaheer et al. 2017).
struct NetworkSize {
  int features = kFeatures, hidden = 96;
};
/// Weight [out, in] and bias [out] of each layer, in order.
struct NetworkLayer {
  int in, out;
};
std::vector<NetworkLayer> network_layers(const NetworkSize& size);
size_t network_parameters(const NetworkSize& size);
/// Per sample: logits, means and widths (before softplus) of the components of z; mean and ln width of
/// log10(rho / mean rho); mean and ln width of (nu - mean nu) / kPoissonUnit.
constexpr int kComponents = 4;
constexpr int kOutputs = 3 * kComponents + 4;
/// Narrowest component in decades: no field is known better, and a likelihood without it has no bound.
constexpr double kNarrowest = 0.05;
constexpr double kPoissonUnit = 0.1;
constexpr float kFarthestFeature = 5;  ///< normalised features end there
constexpr int kContextSamples = 256;   ///< samples over which means and maxima are taken

/// MPDP of Sim Anything (Zhu et al. 2024): how a material is distributed over an object whose mean is known.  Several
/// networks of one size, trained from different starts, agree where they know and differ where they guess; their
/// mixtures are mixed (deep ensembles: Lakshminarayanan et al. 2017).  Each has missed some families of objects.
struct DistributionNetwork {
  NetworkSize size;
  std::vector<float> shift, scale;          ///< [features]: (feature - shift) * scale is about standard
  std::vector<std::vector<float>> members;  ///< [network_parameters] each
  float wide_mean = 0, wide_sigma = 1.5f;   ///< of all training values of z, decades
  float wide_weight = 0.02f;                ///< of that Gaussian in every mixture
  float temperature = 1;                    ///< factor of the widths, from the validation families
  float tail = 0.1f;                        ///< share of a mixture on either side of its 80 % interval, from them too
  std::string recipe = "{}";                ///< JSON: seeds, options and figures of the training
};

/// Initial parameters (He et al. 2015), equal for a seed.
std::vector<float> initial_parameters(const NetworkSize& size, uint64_t seed);
/// [M, features] normalised and bounded.
std::vector<float> normalised(const DistributionNetwork& network, std::span<const float> features);
/// [M, kOutputs] of one member from normalised features.
std::vector<float> network_outputs(const NetworkSize& size, std::span<const float> parameters,
                                   std::span<const float> normalised_features);
/// [members] outputs of each.
std::vector<std::vector<float>> member_outputs(const DistributionNetwork& network,
                                               std::span<const float> normalised_features);
/// [M] calibrated mixtures of the outputs of all members.
std::vector<YoungMixture> young_mixtures(const DistributionNetwork& network,
                                         std::span<const std::vector<float>> outputs);

/// A material per sample around the means of the object.
struct MaterialDistribution {
  std::vector<float> young, young_low, young_high;  ///< [M] Pa; 80 % of the probability lies between low and high
  std::vector<float> sigma;                         ///< [M] standard deviation of log10 E
  std::vector<float> poisson, density;              ///< [M]
};
struct MaterialMeans {
  double young = 1e6, poisson = 0.3, density = 1e3;
};
/// Lowest and highest nu of a field with this mean: 0 and 0.49, or the mean where it lies outside of them.
std::pair<double, double> poisson_range(double mean);
/// E = mean E 10^z, where z of every sample is the quantile of one share, chosen so that the volume-weighted mean of
/// 10^z is 1: samples that are little known give way most.  Where that share would leave the interval, all of it is
/// moved. Density is shifted to its mean; nu likewise, within poisson_range.
MaterialDistribution predict_distribution(const DistributionNetwork& network, std::span<const float> features,
                                          std::span<const float> volume, const MaterialMeans& means);

/// Throws Error{kInput} for a file that is damaged or made for another network or other features.
DistributionNetwork read_network(const std::filesystem::path& file);
void write_network(const std::filesystem::path& file, const DistributionNetwork& network);
/// The weights that the program carries.
DistributionNetwork shipped_network();

}  // namespace pliant
