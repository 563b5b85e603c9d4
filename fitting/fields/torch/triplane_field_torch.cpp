// The part of the triplane field that links libtorch: a module which is loaded on demand and uses nothing of the
// libraries of the program.

#include <algorithm>
#include <cmath>

#include "fitting/fields/torch/tensors.h"
#include "fitting/fields/triplane_field.h"

namespace pliant {
namespace {

class TorchTriplaneField : public TriplaneField {
 public:
  TorchTriplaneField(const TriplaneOptions& options, std::span<const Vec3f> points)
      : options_(options),
        points_(points.size()),
        network_{options.features, options.hidden, options.channels, options.layers, options.scale} {
    for (const Vec3f& x : points) box_.add(x);
    const ThreadScope scope(options_.threads);
    grid_ = plane_grid(box_, points);
    if (!options_.low.empty()) {
      const at::Tensor low = tensor_of(options_.low), high = tensor_of(options_.high);
      middle_ = (low + high) / 2;
      half_ = (high - low) / 2;
    }
  }

  size_t points() const override { return points_; }
  int channels() const override { return options_.channels; }

  size_t parameters() const override { return planes() + network_.parameters(); }

  std::vector<double> constant(std::span<const double> value) const override {
    TORCH_CHECK(value.size() == static_cast<size_t>(options_.channels), "a constant has one value per channel");
    std::vector<double> p(parameters());
    draw_uniform(p, 0, planes(), 0.1, 0.5, options_.seed);
    network_.start(p, options_.seed);
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
    return vector_of(evaluate(checked(parameters), plane_grid(box_, points)));
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
    const ThreadScope scope(options_.threads);
    return loss_adjoint(checked(parameters), gradient,
                        [&](const at::Tensor& leaf) { return weight * total_variation(planes_of(leaf)); });
  }

 private:
  size_t planes() const { return size_t{3} * options_.features * options_.resolution * options_.resolution; }
  at::Tensor planes_of(const at::Tensor& parameters) const {
    return parameters.narrow(0, 0, planes()).view({3, options_.features, options_.resolution, options_.resolution});
  }

  at::Tensor checked(std::span<const double> p) const { return parameter_tensor(p, parameters()); }

  /// z for which bounded(z) = value; a value at or beyond a bound is moved a little inside.
  double before_bounds(int channel, double value) const {
    if (options_.low.empty()) return value;
    const double middle = (options_.low[channel] + options_.high[channel]) / 2;
    const double half = (options_.high[channel] - options_.low[channel]) / 2;
    return middle + half * std::atanh(std::clamp((value - middle) / half, -1 + 1e-6, 1 - 1e-6));
  }

  at::Tensor evaluate(const at::Tensor& parameters, const at::Tensor& grid) const {
    const at::Tensor features = sampled(planes_of(parameters), grid).sum(0).squeeze(1).t();
    const at::Tensor x = network_.evaluate(parameters.narrow(0, planes(), network_.parameters()), features);
    return half_.defined() ? middle_ + half_ * at::tanh((x - middle_) / half_) : x;
  }

  TriplaneOptions options_;
  size_t points_;
  FieldNetwork network_;
  Box box_;
  at::Tensor grid_, middle_, half_;
};

}  // namespace
}  // namespace pliant

extern "C" pliant::TriplaneField* pliant_make_triplane_field(const pliant::TriplaneOptions& options,
                                                             std::span<const pliant::Vec3f> points) {
  return new pliant::TorchTriplaneField(options, points);
}
