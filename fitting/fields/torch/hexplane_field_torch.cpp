// The part of the hexplane field that links libtorch, in the module of the triplane field.

#include <algorithm>

#include "fitting/fields/hexplane_field.h"
#include "fitting/fields/torch/tensors.h"

namespace pliant {
namespace {

/// [M, R] weights of R features on [0, 1] at places [M], by linear interpolation.
at::Tensor hats(const at::Tensor& places, int64_t resolution) {
  const at::Tensor place = (places * (resolution - 1)).clamp(0, resolution - 1);
  const at::Tensor feature = at::arange(resolution, at::TensorOptions(at::kDouble));
  return at::relu(1 - (place.unsqueeze(1) - feature).abs());
}

class TorchHexplaneField : public HexplaneField {
 public:
  TorchHexplaneField(const HexplaneOptions& options, std::span<const Vec3f> points, std::span<const double> times)
      : options_(options),
        points_(static_cast<int64_t>(points.size())),
        times_(static_cast<int64_t>(times.size())),
        network_{options.features, options.hidden, options.channels, options.layers, options.scale} {
    Box box;
    for (const Vec3f& x : points) box.add(x);
    const ThreadScope scope(options_.threads);
    grid_ = plane_grid(box, points);
    const at::Tensor xy = grid_[0][0], yz = grid_[2][0];
    for (const at::Tensor& axis : {xy.select(1, 0), xy.select(1, 1), yz.select(1, 1)})
      space_hats_.push_back(hats((axis + 1) / 2, options_.space_resolution));
    time_hats_ = hats(tensor_of(times), options_.time_resolution);
  }

  size_t points() const override { return static_cast<size_t>(times_ * points_); }
  int channels() const override { return options_.channels; }
  size_t parameters() const override { return space_size() + time_size() + network_.parameters(); }

  std::vector<double> constant(std::span<const double> value) const override {
    TORCH_CHECK(value.size() == static_cast<size_t>(options_.channels), "a constant has one value per channel");
    std::vector<double> p(parameters(), 1.0);
    draw_uniform(p, 0, space_size(), 0.1, 0.5, options_.seed);
    network_.start(p, options_.seed);
    std::copy(value.begin(), value.end(), p.end() - value.size());
    return p;
  }

  std::vector<double> values(std::span<const double> parameters) const override {
    const ThreadScope scope(options_.threads);
    const at::Tensor p = checked(parameters), space = space_features(p), lines = lines_of(p);
    std::vector<double> out;
    out.reserve(points() * options_.channels);
    for (int64_t time = 0; time < times_; ++time) {
      const at::Tensor now = evaluate(space, lines[time], network_of(p)).contiguous();
      out.insert(out.end(), now.data_ptr<double>(), now.data_ptr<double>() + now.numel());
    }
    return out;
  }

  /// Goes back through one time after the other, so that memory is that of one.
  std::vector<double> values_adjoint(std::span<const double> parameters,
                                     std::span<const double> adj_values) const override {
    TORCH_CHECK(adj_values.size() == points() * options_.channels, "the derivatives are by all values");
    const ThreadScope scope(options_.threads);
    const at::Tensor leaf = checked(parameters).clone().set_requires_grad(true);
    const at::Tensor space = space_features(leaf), lines = lines_of(leaf);
    const at::Tensor space_leaf = space.detach().set_requires_grad(true),
                     network_leaf = network_of(leaf).detach().clone().set_requires_grad(true);
    const at::Tensor adj_space = at::zeros_like(space_leaf), adj_lines = at::zeros_like(lines),
                     adj_network = at::zeros_like(network_leaf);
    const at::Tensor adj = tensor_of(adj_values).view({times_, points_, options_.channels});
    for (int64_t time = 0; time < times_; ++time) {
      const at::Tensor line = lines[time].detach().set_requires_grad(true);
      const at::Tensor now = evaluate(space_leaf, line, network_leaf);
      const auto adj_now = torch::autograd::grad({now}, {space_leaf, line, network_leaf}, {adj[time]});
      adj_space.add_(adj_now[0]);
      adj_lines[time].copy_(adj_now[1]);
      adj_network.add_(adj_now[2]);
    }
    const at::Tensor adj_leaf = torch::autograd::grad({space, lines}, {leaf}, {adj_space, adj_lines})[0];
    network_of(adj_leaf).add_(adj_network);
    return vector_of(adj_leaf);
  }

  double roughness(std::span<const double> parameters, double weight, std::span<double> gradient) const override {
    const ThreadScope scope(options_.threads);
    return loss_adjoint(checked(parameters), gradient, [&](const at::Tensor& leaf) {
      const at::Tensor planes = time_planes(leaf);
      const int64_t inner = options_.time_resolution - 2;
      const at::Tensor second =
          planes.narrow(2, 0, inner) - 2 * planes.narrow(2, 1, inner) + planes.narrow(2, 2, inner);
      return weight * (total_variation(space_planes(leaf)) + 3 * second.square().mean());
    });
  }

 private:
  size_t space_size() const {
    return size_t{3} * options_.features * options_.space_resolution * options_.space_resolution;
  }
  size_t time_size() const {
    return size_t{3} * options_.features * options_.time_resolution * options_.space_resolution;
  }

  at::Tensor checked(std::span<const double> p) const { return parameter_tensor(p, parameters()); }

  at::Tensor space_planes(const at::Tensor& parameters) const {
    const int64_t side = options_.space_resolution;
    return parameters.narrow(0, 0, space_size()).view({3, options_.features, side, side});
  }
  at::Tensor time_planes(const at::Tensor& parameters) const {
    return parameters.narrow(0, space_size(), time_size())
        .view({3, options_.features, options_.time_resolution, options_.space_resolution});
  }
  at::Tensor network_of(const at::Tensor& parameters) const {
    return parameters.narrow(0, space_size() + time_size(), network_.parameters());
  }

  /// [points, features] product of the planes of space, which all times share.
  at::Tensor space_features(const at::Tensor& parameters) const {
    const at::Tensor features = sampled(space_planes(parameters), grid_).squeeze(2);  // [3, features, points]
    return (features[0] * features[1] * features[2]).t().contiguous();
  }

  /// [times, 3, space, features] the planes of time at the times.
  at::Tensor lines_of(const at::Tensor& parameters) const {
    return at::matmul(time_hats_, time_planes(parameters)).permute({2, 0, 3, 1}).contiguous();
  }

  /// [points, channels] at one time, whose line is [3, space, features].
  at::Tensor evaluate(const at::Tensor& space, const at::Tensor& line, const at::Tensor& network) const {
    at::Tensor features = space;
    for (int axis = 0; axis < 3; ++axis) features = features * at::matmul(space_hats_[axis], line[axis]);
    return network_.evaluate(network, features);
  }

  HexplaneOptions options_;
  int64_t points_, times_;
  FieldNetwork network_;
  at::Tensor grid_, time_hats_;         // [3, 1, points, 2], [times, time]
  std::vector<at::Tensor> space_hats_;  // of each axis, [points, space]
};

}  // namespace
}  // namespace pliant

extern "C" pliant::HexplaneField* pliant_make_hexplane_field(const pliant::HexplaneOptions& options,
                                                             std::span<const pliant::Vec3f> points,
                                                             std::span<const double> times) {
  return new pliant::TorchHexplaneField(options, points, times);
}
