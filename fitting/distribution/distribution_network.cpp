#include "fitting/distribution/distribution_network.h"

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

double softplus(double x) { return x > 30 ? x : std::log1p(std::exp(x)); }

/// Reads the layers off the parameters one after the other.
class Layers {
 public:
  Layers(const NetworkSize& size, std::span<const float> parameters) : layers_(network_layers(size)), p_(parameters) {
    CHECK(p_.size() == network_parameters(size));
  }
  /// Of rows x, and with a context c [1, C] of rows (x, c).
  Rows next(const Rows& x, bool rectify, const Rows& context = Rows(1, 0)) {
    const auto [in, out] = layers_[layer_++];
    CHECK(x.cols() + context.cols() == in);
    const Eigen::Map<const Rows> weight(p_.data() + at_, out, in);
    const Eigen::Map<const Eigen::RowVectorXf> bias(p_.data() + at_ + in * out, out);
    at_ += static_cast<size_t>(in + 1) * out;
    const Eigen::RowVectorXf shift = bias + context.row(0) * weight.rightCols(context.cols()).transpose();
    Rows y(x.rows(), out);
    // Blocks of one size, so that the result does not depend on the number of threads.
    constexpr Eigen::Index kBlock = 512;
    parallel_for((x.rows() + kBlock - 1) / kBlock,
                 [&](std::ptrdiff_t b) {
                   const Eigen::Index begin = b * kBlock, rows = std::min(kBlock, x.rows() - begin);
                   auto block = y.middleRows(begin, rows);
                   block.noalias() = x.middleRows(begin, rows) * weight.leftCols(x.cols()).transpose();
                   block.rowwise() += shift;
                   if (rectify) block = block.cwiseMax(0.0f);
                 },
                 1);
    return y;
  }

 private:
  std::vector<NetworkLayer> layers_;
  std::span<const float> p_;
  size_t layer_ = 0, at_ = 0;
};

/// Mean and maximum [1, 2 H] over the rows that stand for the object.
Rows context_of(const Rows& h) {
  const Eigen::Index n = std::min<Eigen::Index>(h.rows(), kContextSamples);
  Rows out = Rows::Zero(1, 2 * h.cols());
  out.rightCols(h.cols()).setConstant(-INFINITY);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto row = h.row(i * h.rows() / n);
    out.leftCols(h.cols()) += row / static_cast<float>(n);
    out.rightCols(h.cols()) = out.rightCols(h.cols()).cwiseMax(row);
  }
  return out;
}

/// Adds to z what makes the volume-weighted mean of 10^z one.
double shift_to_mean(std::span<const double> z, std::span<const float> volume) {
  double sum = 0, total = 0;
  for (size_t i = 0; i < z.size(); ++i) {
    sum += volume[i] * std::pow(10.0, z[i]);
    total += volume[i];
  }
  return -std::log10(sum / total);
}

/// The share at which the volume-weighted mean of 10^quantile is one, from samples that stand for all.
double share_of_mean(const std::vector<YoungMixture>& mixtures, std::span<const float> volume, double tail) {
  const size_t m = mixtures.size(), n = std::min<size_t>(m, 4 * kContextSamples);
  std::vector<double> z(n);
  std::vector<float> v;
  for (size_t i = 0; i < n; ++i) v.push_back(volume[i * m / n]);
  double low = tail, high = 1 - tail;
  for (int step = 0; step < 12; ++step) {
    const double middle = 0.5 * (low + high);
    parallel_for(
        static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) { z[i] = mixtures[i * m / n].quantile(middle); }, 64);
    (shift_to_mean(z, v) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::vector<NetworkLayer> network_layers(const NetworkSize& size) {
  const int h = size.hidden;
  return {{size.features, h}, {h, h}, {2 * h, h}, {2 * h, h}, {2 * h, h}, {2 * h, h}, {h, kOutputs}};
}

size_t network_parameters(const NetworkSize& size) {
  size_t count = 0;
  for (const auto [in, out] : network_layers(size)) count += static_cast<size_t>(in + 1) * out;
  return count;
}

std::vector<float> initial_parameters(const NetworkSize& size, uint64_t seed) {
  std::vector<float> p;
  for (const auto [in, out] : network_layers(size)) {
    const double deviation = std::sqrt(2.0 / in) * (out == kOutputs ? 0.3 : 1);
    for (int i = 0; i < in * out; ++i) p.push_back(static_cast<float>(deviation * Random(seed, p.size()).normal()));
    p.resize(p.size() + out, 0.0f);
  }
  // Components begin apart, one decade wide.
  float* bias = p.data() + p.size() - kOutputs;
  for (int k = 0; k < kComponents; ++k) bias[kComponents + k] = 0.2f - 0.8f * static_cast<float>(k);
  return p;
}

std::vector<float> normalised(const DistributionNetwork& network, std::span<const float> features) {
  const size_t f = network.size.features;
  CHECK(features.size() % f == 0 && network.shift.size() == f && network.scale.size() == f);
  std::vector<float> out(features.size());
  for (size_t i = 0; i < features.size(); ++i)
    out[i] =
        std::clamp((features[i] - network.shift[i % f]) * network.scale[i % f], -kFarthestFeature, kFarthestFeature);
  return out;
}

std::vector<float> network_outputs(const NetworkSize& size, std::span<const float> parameters,
                                   std::span<const float> features) {
  const Eigen::Index rows = static_cast<Eigen::Index>(features.size()) / size.features;
  CHECK(rows > 0 && static_cast<size_t>(rows) * size.features == features.size());
  Layers layers(size, parameters);
  Rows h = layers.next(Eigen::Map<const Rows>(features.data(), rows, size.features), true);
  h = layers.next(h, true);
  for (int pooling = 0; pooling < 2; ++pooling) {
    const Rows whole = layers.next(context_of(h), true);
    h = layers.next(h, true, whole);
  }
  const Rows y = layers.next(h, false);
  return {y.data(), y.data() + y.size()};
}

std::vector<std::vector<float>> member_outputs(const DistributionNetwork& network, std::span<const float> features) {
  CHECK(!network.members.empty());
  std::vector<std::vector<float>> out;
  for (const auto& parameters : network.members) out.push_back(network_outputs(network.size, parameters, features));
  return out;
}

std::vector<YoungMixture> young_mixtures(const DistributionNetwork& network,
                                         std::span<const std::vector<float>> outputs) {
  std::vector<YoungMixture> mixtures(outputs[0].size() / kOutputs);
  for (size_t i = 0; i < mixtures.size(); ++i) {
    auto& parts = mixtures[i].parts;
    for (const std::vector<float>& member : outputs) {
      const float* y = member.data() + i * kOutputs;
      const float largest = *std::max_element(y, y + kComponents);
      double sum = 0;
      for (int k = 0; k < kComponents; ++k) sum += std::exp(y[k] - largest);
      sum *= static_cast<double>(outputs.size()) / (1 - network.wide_weight);
      for (int k = 0; k < kComponents; ++k)
        parts.push_back({std::exp(y[k] - largest) / sum, y[kComponents + k],
                         network.temperature * (kNarrowest + softplus(y[2 * kComponents + k]))});
    }
    parts.push_back({network.wide_weight, network.wide_mean, network.wide_sigma});
  }
  return mixtures;
}

std::pair<double, double> poisson_range(double mean) { return {std::min(0.0, mean), std::max(0.49, mean)}; }

MaterialDistribution predict_distribution(const DistributionNetwork& network, std::span<const float> features,
                                          std::span<const float> volume, const MaterialMeans& means) {
  const size_t m = volume.size();
  CHECK(features.size() == m * network.size.features);
  const auto outputs = member_outputs(network, normalised(network, features));
  const std::vector<YoungMixture> mixtures = young_mixtures(network, outputs);
  const auto of_members = [&](size_t i, int output) {
    double sum = 0;
    for (const auto& member : outputs) sum += member[i * kOutputs + output];
    return sum / static_cast<double>(outputs.size());
  };
  const double share = share_of_mean(mixtures, volume, network.tail);
  std::vector<double> middle(m), low(m), high(m), rho(m), poisson(m);
  double nu = 0, total = 0;
  MaterialDistribution out;
  out.sigma.resize(m);
  parallel_for(
      static_cast<std::ptrdiff_t>(m),
      [&](std::ptrdiff_t i) {
        const YoungMixture& mixture = mixtures[i];
        middle[i] = mixture.quantile(share);
        low[i] = mixture.quantile(network.tail);
        high[i] = mixture.quantile(1 - network.tail);
        out.sigma[i] = static_cast<float>(mixture.deviation());
        rho[i] = of_members(i, 3 * kComponents);
        poisson[i] = kPoissonUnit * of_members(i, 3 * kComponents + 2);
      },
      64);
  for (size_t i = 0; i < m; ++i) {
    nu += volume[i] * poisson[i];
    total += volume[i];
  }
  const auto [lowest, highest] = poisson_range(means.poisson);
  const double shift = shift_to_mean(middle, volume), rho_shift = shift_to_mean(rho, volume);
  for (size_t i = 0; i < m; ++i) {
    const auto young = [&](double z) { return static_cast<float>(means.young * std::pow(10.0, z + shift)); };
    out.young.push_back(young(middle[i]));
    out.young_low.push_back(young(low[i]));
    out.young_high.push_back(young(high[i]));
    out.density.push_back(static_cast<float>(means.density * std::pow(10.0, rho[i] + rho_shift)));
    out.poisson.push_back(static_cast<float>(std::clamp(means.poisson + poisson[i] - nu / total, lowest, highest)));
  }
  return out;
}

}  // namespace pliant
