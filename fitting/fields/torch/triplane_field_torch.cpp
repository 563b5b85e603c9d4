// The part of the triplane field that links libtorch: a module which is loaded on demand and uses nothing of the
// libraries of the program.

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <omp.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <cmath>

#include "fitting/fields/triplane_field.h"
#include "gaussians/base/random.h"

namespace pliant {
namespace {

/// Sets torch's number of threads, which is also OpenMP's, and gives OpenMP back its own.
class ThreadScope {
 public:
  explicit ThreadScope(int threads) : saved_(omp_get_max_threads()) { at::set_num_threads(threads); }
  ~ThreadScope() { omp_set_num_threads(saved_); }

 private:
  int saved_;
};

at::Tensor tensor_of(std::span<const double> values) {
  return at::from_blob(const_cast<double*>(values.data()), {static_cast<int64_t>(values.size())}, at::kDouble);
}

std::vector<double> vector_of(const at::Tensor& tensor) {
  const at::Tensor whole = tensor.contiguous();
  return {whole.data_ptr<double>(), whole.data_ptr<double>() + whole.numel()};
}

class TorchTriplaneField : public TriplaneField {
 public:
  TorchTriplaneField(const TriplaneOptions& options, std::span<const Vec3f> points)
      : options_(options), points_(points.size()) {
    for (const Vec3f& x : points) box_.add(x);
    const ThreadScope scope(options_.threads);
    grid_ = grid_of(points);
    if (!options_.low.empty()) {
      const at::Tensor low = tensor_of(options_.low), high = tensor_of(options_.high);
      middle_ = (low + high) / 2;
      half_ = (high - low) / 2;
    }
  }

  size_t points() const override { return points_; }
  int channels() const override { return options_.channels; }

  size_t parameters() const override {
    size_t count = planes();
    for (int layer = 0; layer < options_.layers; ++layer) count += width(layer + 1) * (width(layer) + 1);
    return count;
  }

  std::vector<double> constant(std::span<const double> value) const override {
    TORCH_CHECK(value.size() == static_cast<size_t>(options_.channels), "a constant has one value per channel");
    std::vector<double> p(parameters());
    const auto draw = [&](size_t i, double low, double high) { p[i] = Random(options_.seed, i).uniform(low, high); };
    size_t at = 0;
    for (; at < planes(); ++at) draw(at, 0.1, 0.5);
    for (int layer = 0; layer + 1 < options_.layers; ++layer) {
      const double bound = 1 / std::sqrt(static_cast<double>(width(layer)));
      for (const size_t end = at + width(layer + 1) * (width(layer) + 1); at < end; ++at) draw(at, -bound, bound);
    }
    for (size_t c = 0; c < value.size(); ++c)
      p[p.size() - value.size() + c] = before_bounds(static_cast<int>(c), value[c]);
    return p;
  }

  std::vector<double> values(std::span<const double> parameters) const override {
    const ThreadScope scope(options_.threads);
    return vector_of(evaluate(checked(parameters), grid_));
  }

  std::vector<double> values_at(std::span<const double> parameters, std::span<const Vec3f> points) const override {
    const ThreadScope scope(options_.threads);
    return vector_of(evaluate(checked(parameters), grid_of(points)));
  }

  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override {
    TORCH_CHECK(adj_values.size() == points_ * options_.channels, "the derivatives are by all values");
    const ThreadScope scope(options_.threads);
    const at::Tensor leaf = checked(parameters).clone().set_requires_grad(true);
    const at::Tensor out = evaluate(leaf, grid_);
    return vector_of(torch::autograd::grad({out}, {leaf}, {tensor_of(adj_values).view_as(out)})[0]);
  }

  double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const override {
    TORCH_CHECK(gradient.empty() || gradient.size() == parameters.size(), "the gradient is by all parameters");
    const ThreadScope scope(options_.threads);
    const at::Tensor leaf = checked(parameters).clone().set_requires_grad(!gradient.empty());
    const at::Tensor plane = planes_of(leaf);
    const int64_t r = options_.resolution;
    at::Tensor sum = at::zeros({}, at::kDouble);
    for (const int64_t axis : {2, 3}) {
      const at::Tensor step = plane.narrow(axis, 1, r - 1) - plane.narrow(axis, 0, r - 1);
      sum = sum + 3 * step.square().mean();
    }
    sum = weight * sum;
    if (!gradient.empty()) tensor_of(gradient) += torch::autograd::grad({sum}, {leaf})[0];
    return sum.item<double>();
  }

 private:
  int width(int layer) const {
    return layer == 0 ? options_.features : layer == options_.layers ? options_.channels : options_.hidden;
  }
  size_t planes() const { return size_t{3} * options_.features * options_.resolution * options_.resolution; }
  at::Tensor planes_of(const at::Tensor& parameters) const {
    return parameters.narrow(0, 0, planes()).view({3, options_.features, options_.resolution, options_.resolution});
  }

  at::Tensor checked(std::span<const double> p) const {
    TORCH_CHECK(p.size() == parameters(), "the field has ", parameters(), " parameters, not ", p.size());
    return tensor_of(p);
  }

  /// [3, 1, M, 2] places on the planes in [-1, 1].
  at::Tensor grid_of(std::span<const Vec3f> points) const {
    constexpr int kFirst[3] = {0, 0, 1}, kSecond[3] = {1, 2, 2};
    const Vec3d centre = box_.centre().cast<double>(), half = 0.5 * box_.size().cast<double>().cwiseMax(1e-30f);
    at::Tensor grid = at::empty({3, 1, static_cast<int64_t>(points.size()), 2}, at::kDouble);
    double* out = grid.data_ptr<double>();
    for (int plane = 0; plane < 3; ++plane)
      for (const Vec3f& point : points) {
        const Vec3d x = (point.cast<double>() - centre).cwiseQuotient(half);
        *out++ = x[kFirst[plane]];
        *out++ = x[kSecond[plane]];
      }
    return grid;
  }

  /// z for which bounded(z) = value; a value at or beyond a bound is moved a little inside.
  double before_bounds(int channel, double value) const {
    if (options_.low.empty()) return value;
    const double middle = (options_.low[channel] + options_.high[channel]) / 2;
    const double half = (options_.high[channel] - options_.low[channel]) / 2;
    return middle + half * std::atanh(std::clamp((value - middle) / half, -1 + 1e-6, 1 - 1e-6));
  }

  at::Tensor evaluate(const at::Tensor& parameters, const at::Tensor& grid) const {
    // Bilinear = 0, values beyond the border = 1, corners of the box at the centres of the corner features.
    const at::Tensor sampled = at::grid_sampler_2d(planes_of(parameters), grid, 0, 1, true);  // [3, features, 1, M]
    at::Tensor x = sampled.sum(0).squeeze(1).t();
    int64_t at = planes();
    for (int layer = 0; layer < options_.layers; ++layer) {
      const int64_t in = width(layer), out = width(layer + 1);
      const at::Tensor weight = parameters.narrow(0, at, out * in).view({out, in}),
                       bias = parameters.narrow(0, at + out * in, out);
      at += out * (in + 1);
      const bool last = layer + 1 == options_.layers;
      x = at::matmul(x, weight.t());
      x = last ? options_.scale * x + bias : at::relu(x + bias);
    }
    return half_.defined() ? middle_ + half_ * at::tanh((x - middle_) / half_) : x;
  }

  TriplaneOptions options_;
  size_t points_;
  Box box_;
  at::Tensor grid_, middle_, half_;
};

}  // namespace
}  // namespace pliant

extern "C" pliant::TriplaneField* pliant_make_triplane_field(const pliant::TriplaneOptions& options,
                                                             std::span<const pliant::Vec3f> points) {
  return new pliant::TorchTriplaneField(options, points);
}
