// The part of the network's training that links libtorch: a module which is loaded on demand and uses nothing of the
// libraries of the program.

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <omp.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>

#include "fitting/distribution/distribution_loss.h"

namespace pliant {
namespace {

constexpr double kShareOfOthers = 0.1;

/// Sets torch's number of threads, which is also OpenMP's, and gives OpenMP back its own.
class TorchThreads {
 public:
  explicit TorchThreads(int threads) : saved_(omp_get_max_threads()) { at::set_num_threads(threads); }
  ~TorchThreads() { omp_set_num_threads(saved_); }

 private:
  int saved_;
};

/// The values as they lie in memory.
at::Tensor view_of(std::span<const float> values, at::IntArrayRef shape) {
  return at::from_blob(const_cast<float*>(values.data()), shape, at::kFloat);
}

class TorchDistributionLoss : public DistributionLoss {
 public:
  TorchDistributionLoss(const DistributionNetwork& network, int threads, bool in_double)
      : type_(in_double ? at::kDouble : at::kFloat),
        features_(network.size.features),
        hidden_(network.size.hidden),
        wide_mean_(network.wide_mean),
        wide_sigma_(network.wide_sigma),
        wide_weight_(network.wide_weight),
        threads_(threads) {}

  double value(std::span<const float> parameters, const TrainingBatch& batch,
               std::span<float> gradient) const override {
    const TorchThreads scope(threads_);
    const int64_t count = static_cast<int64_t>(parameters.size());
    const at::Tensor leaf = tensor_of(parameters, {count}).set_requires_grad(!gradient.empty());
    const at::Tensor loss = likelihood(forward(leaf, batch), batch);
    if (!gradient.empty()) view_of(gradient, {count}).copy_(torch::autograd::grad({loss}, {leaf})[0]);
    return loss.item<double>();
  }

  std::vector<float> outputs(std::span<const float> parameters, const TrainingBatch& batch) const override {
    const TorchThreads scope(threads_);
    const int64_t count = static_cast<int64_t>(parameters.size());
    const at::Tensor y = forward(tensor_of(parameters, {count}), batch).to(at::kFloat).contiguous();
    return {y.data_ptr<float>(), y.data_ptr<float>() + y.numel()};
  }

 private:
  at::Tensor tensor_of(std::span<const float> values, at::IntArrayRef shape) const {
    return view_of(values, shape).to(type_);
  }

  at::Tensor forward(const at::Tensor& parameters, const TrainingBatch& batch) const {
    int64_t at = 0;
    const auto layer = [&](const at::Tensor& x, int64_t out, bool rectify) {
      const int64_t in = x.size(-1);
      const at::Tensor weight = parameters.narrow(0, at, in * out).view({out, in}),
                       bias = parameters.narrow(0, at + in * out, out);
      at += (in + 1) * out;
      const at::Tensor y = at::linear(x, weight, bias);
      return rectify ? at::relu(y) : y;
    };
    at::Tensor h = tensor_of(batch.features, {batch.objects, batch.samples, features_});
    h = layer(h, hidden_, true);
    h = layer(h, hidden_, true);
    for (int pooling = 0; pooling < 2; ++pooling) {
      const at::Tensor context = at::cat({h.mean(1, true), h.amax(1, true)}, 2);
      const at::Tensor whole = layer(context, hidden_, true);
      h = layer(at::cat({h, whole.expand({batch.objects, batch.samples, hidden_})}, 2), hidden_, true);
    }
    const at::Tensor y = layer(h, kOutputs, false);
    TORCH_CHECK(at == parameters.numel(), "the network has ", at, " parameters, not ", parameters.numel());
    return y;
  }

  static at::Tensor log_gaussian(const at::Tensor& unit, const at::Tensor& log_sigma) {
    return -0.5 * unit.square() - log_sigma - 0.5 * std::log(2 * M_PI);
  }

  at::Tensor likelihood(const at::Tensor& y, const TrainingBatch& batch) const {
    const at::Tensor target = tensor_of(batch.target, {batch.objects, batch.samples, 3});
    const at::Tensor z = target.narrow(2, 0, 1), mean = y.narrow(2, kComponents, kComponents);
    const at::Tensor sigma = kNarrowest + at::softplus(y.narrow(2, 2 * kComponents, kComponents));
    const at::Tensor own = at::log_softmax(y.narrow(2, 0, kComponents), 2) + std::log(1 - wide_weight_) +
                           log_gaussian((z - mean) / sigma, sigma.log());
    const at::Tensor unit = (z - wide_mean_) / wide_sigma_;
    const at::Tensor wide = std::log(wide_weight_) + log_gaussian(unit, at::full_like(unit, std::log(wide_sigma_)));
    at::Tensor sum = at::logsumexp(at::cat({own, wide}, 2), 2).mean();
    for (const int other : {0, 1}) {
      const int64_t at = 3 * kComponents + 2 * other;
      // Widths from 1 % to e units, so that a homogeneous density has no endless likelihood.
      const at::Tensor log_sigma = at::clamp(y.narrow(2, at + 1, 1), -3.5, 1.0);
      const at::Tensor wanted = target.narrow(2, 1 + other, 1) * (other ? 1 / kPoissonUnit : 1.0);
      sum = sum + kShareOfOthers * log_gaussian((wanted - y.narrow(2, at, 1)) * (-log_sigma).exp(), log_sigma).mean();
    }
    return -sum;
  }

  at::ScalarType type_;
  int64_t features_, hidden_;
  double wide_mean_, wide_sigma_, wide_weight_;
  int threads_;
};

}  // namespace
}  // namespace pliant

extern "C" pliant::DistributionLoss* pliant_make_distribution_loss(const pliant::DistributionNetwork& network,
                                                                   int threads, bool in_double) {
  return new pliant::TorchDistributionLoss(network, threads, in_double);
}
