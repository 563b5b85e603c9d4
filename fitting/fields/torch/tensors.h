#pragma once

// What the fields that link libtorch share.  Uses nothing of the libraries of the program but headers.

#include <ATen/ATen.h>
#include <ATen/Parallel.h>
#include <omp.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <span>
#include <vector>

#include "gaussians/base/random.h"
#include "gaussians/base/types.h"

namespace pliant {

/// Sets torch's number of threads, which is also OpenMP's, and gives OpenMP back its own.
class ThreadScope {
 public:
  explicit ThreadScope(int threads) : saved_(omp_get_max_threads()) { at::set_num_threads(threads); }
  ~ThreadScope() { omp_set_num_threads(saved_); }

 private:
  int saved_;
};

/// The values as they lie in memory.
inline at::Tensor tensor_of(std::span<const double> values) {
  return at::from_blob(const_cast<double*>(values.data()), {static_cast<int64_t>(values.size())}, at::kDouble);
}

/// The same of a field's parameters, of which there must be `count`.
inline at::Tensor parameter_tensor(std::span<const double> p, size_t count) {
  TORCH_CHECK(p.size() == count, "the field has ", count, " parameters, not ", p.size());
  return tensor_of(p);
}

inline std::vector<double> vector_of(const at::Tensor& tensor) {
  const at::Tensor whole = tensor.contiguous();
  return {whole.data_ptr<double>(), whole.data_ptr<double>() + whole.numel()};
}

/// Element i of `all` becomes the draw i of the seed, from `first` to before `end`.
inline void draw_uniform(std::span<double> all, size_t first, size_t end, double low, double high, uint64_t seed) {
  for (size_t i = first; i < end; ++i) all[i] = Random(seed, i).uniform(low, high);
}

/// [3, 1, M, 2] places in the box on its planes xy, xz and yz, in [-1, 1].
inline at::Tensor plane_grid(const Box& box, std::span<const Vec3f> points) {
  constexpr int kFirst[3] = {0, 0, 1}, kSecond[3] = {1, 2, 2};
  const Vec3d centre = box.centre().cast<double>(), half = 0.5 * box.size().cast<double>().cwiseMax(1e-30f);
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

/// [3, features, 1, M] features of planes [3, features, R, R] at places of plane_grid: bilinear, beyond the border as
/// on it, corners of the box at the centres of the corner features.
inline at::Tensor sampled(const at::Tensor& planes, const at::Tensor& grid) {
  return at::grid_sampler_2d(planes, grid, 0, 1, true);
}

/// Mean squared difference of neighbours along both axes, summed over planes [planes, features, rows, columns].
inline at::Tensor total_variation(const at::Tensor& planes) {
  at::Tensor sum = at::zeros({}, at::kDouble);
  for (const int64_t axis : {2, 3}) {
    const int64_t steps = planes.size(axis) - 1;
    const at::Tensor step = planes.narrow(axis, 1, steps) - planes.narrow(axis, 0, steps);
    sum = sum + planes.size(0) * step.square().mean();
  }
  return sum;
}

/// loss(parameters), a scalar; adds its derivatives to `gradient` [P] unless that is empty.
template <class Loss>
double loss_adjoint(const at::Tensor& parameters, std::span<double> gradient, Loss&& loss) {
  TORCH_CHECK(gradient.empty() || static_cast<int64_t>(gradient.size()) == parameters.numel(),
              "the gradient is by all parameters");
  const at::Tensor leaf = parameters.clone().set_requires_grad(!gradient.empty());
  const at::Tensor value = loss(leaf);
  if (!gradient.empty()) tensor_of(gradient) += torch::autograd::grad({value}, {leaf})[0];
  return value.template item<double>();
}

/// Linear layers with ReLU between them.  Parameters: weight [out, in] and bias [out] of each.
struct FieldNetwork {
  int in = 1, hidden = 1, out = 1, layers = 1;
  double scale = 1;  ///< of what the last layer adds to its bias

  int width(int layer) const { return layer == 0 ? in : layer == layers ? out : hidden; }

  size_t parameters() const {
    size_t count = 0;
    for (int layer = 0; layer < layers; ++layer) count += width(layer + 1) * (width(layer) + 1);
    return count;
  }

  /// Draws the last parameters of `all` for a start at the constant 0: the last layer is 0.
  void start(std::span<double> all, uint64_t seed) const {
    size_t at = all.size() - parameters();
    for (int layer = 0; layer + 1 < layers; ++layer) {
      const double bound = 1 / std::sqrt(static_cast<double>(width(layer)));
      const size_t end = at + width(layer + 1) * (width(layer) + 1);
      draw_uniform(all, at, end, -bound, bound, seed);
      at = end;
    }
    for (; at < all.size(); ++at) all[at] = 0;
  }

  /// [M, out] of x [M, in]; the parameters are its own.
  at::Tensor evaluate(const at::Tensor& parameters, at::Tensor x) const {
    int64_t at = 0;
    for (int layer = 0; layer < layers; ++layer) {
      const int64_t from = width(layer), to = width(layer + 1);
      const at::Tensor weight = parameters.narrow(0, at, to * from).view({to, from}),
                       bias = parameters.narrow(0, at + to * from, to);
      at += to * (from + 1);
      x = at::matmul(x, weight.t());
      x = layer + 1 == layers ? scale * x + bias : at::relu(x + bias);
    }
    return x;
  }
};

}  // namespace pliant
