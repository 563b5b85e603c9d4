#include "fitting/objective/flow_loss.h"

#include <cmath>

#include "fitting/objective/body_points.h"
#include "gaussians/base/error.h"

namespace pliant {
namespace {

/// Whether both ends of a way can be projected.
template <class T>
bool in_front(const Camera& camera, const Vec3<T>& a, const Vec3<T>& b) {
  const auto z = [&](const Vec3<T>& X) { return (camera.cam_from_world * X.template cast<double>()).z(); };
  return z(a) > 1e-3 && z(b) > 1e-3;
}

/// [N, 2] px by which Gaussians move in the picture; those before `first` stand still.
template <class T>
std::vector<T> ways(const Camera& camera, const std::vector<Vec3<T>>& from, const std::vector<Vec3<T>>& to,
                    size_t first) {
  std::vector<T> way(2 * from.size(), T(0));
  for (size_t g = first; g < from.size(); ++g) {
    if (!in_front(camera, from[g], to[g])) continue;
    const auto moved = (project_point<T>(camera, to[g]) - project_point<T>(camera, from[g])).eval();
    way[2 * g] = moved.x();
    way[2 * g + 1] = moved.y();
  }
  return way;
}

}  // namespace

template <class T, bool kCutOffs>
FlowLoss<T, kCutOffs>::FlowLoss(std::shared_ptr<const DrawnObject<T>> object, SeenFlow<T> seen, double outlier)
    : object_(std::move(object)), seen_(std::move(seen)), outlier_(outlier) {
  CHECK(outlier > 0);
  for (const auto& pair : seen_.pairs) {
    CHECK(pair.flow.width == seen_.camera.width && pair.flow.height == seen_.camera.height && pair.flow.channels == 2);
    CHECK(pair.weight.data.size() * 2 == pair.flow.data.size());
    for (const T w : pair.weight.data) total_weight_ += double(w);
  }
}

template <class T, bool kCutOffs>
double FlowLoss<T, kCutOffs>::of_pair(const typename SeenFlow<T>::Pair& pair,
                                      std::span<const BasicSimulationState<T>> frames, double adj_value,
                                      std::span<StateGradient<T>> gradient) const {
  const BasicSimulationState<T>&from = frames[pair.from], &to = frames[pair.to];
  const CloudOf<T> all = object_->at(from), later = object_->at(to);
  const size_t first = object_->background.size();
  const std::vector<T> way = ways<T>(seen_.camera, all.position, later.position, first);
  const RenderOptions options = object_->render.within(seen_.frame);
  RenderTape<T> tape;
  const Rendered<T> picture =
      render_as<T, kCutOffs>(all, seen_.camera, options, way, 2, gradient.empty() ? nullptr : &tape);

  double loss = 0;
  const double d2 = outlier_ * outlier_;
  Rendered<T> adj;
  if (!gradient.empty()) adj.features = Image<T>(pair.flow.width, pair.flow.height, 2);
  for (size_t i = 0; i < pair.weight.data.size(); ++i) {
    const double weight = double(pair.weight.data[i]) / total_weight_;
    if (!(weight > 0)) continue;
    const double x = double(picture.features.data[2 * i]) - pair.flow.data[2 * i],
                 y = double(picture.features.data[2 * i + 1]) - pair.flow.data[2 * i + 1];
    const double root = std::sqrt(1 + (x * x + y * y) / d2);
    loss += weight * 2 * d2 * (root - 1);
    if (gradient.empty()) continue;
    adj.features.data[2 * i] = T(adj_value * weight * 2 / root * x);
    adj.features.data[2 * i + 1] = T(adj_value * weight * 2 / root * y);
  }
  if (gradient.empty()) return loss;

  GradientExtras extras;
  extras.covariance = true;
  RenderGradient<T> by =
      render_adjoint_as<T, kCutOffs>(all, seen_.camera, options, way, 2, picture, adj, &tape, extras);
  std::vector<Vec3<T>> by_later(all.size(), Vec3<T>::Zero());
  for (size_t g = first; g < all.size(); ++g) {
    if (!in_front(seen_.camera, all.position[g], later.position[g])) continue;
    const Eigen::Matrix<T, 2, 1> by_way(by.features[2 * g], by.features[2 * g + 1]);
    by_later[g] = project_point_adjoint<T>(seen_.camera, later.position[g], by_way);
    by.cloud.position[g] -= project_point_adjoint<T>(seen_.camera, all.position[g], by_way);
  }
  object_->at_adjoint(from, by.cloud.position, by.covariance, by.cloud.sh, gradient[pair.from]);
  const std::vector<Mat3<T>> none(all.size(), Mat3<T>::Zero());
  object_->at_adjoint(to, by_later, none, {}, gradient[pair.to]);
  return loss;
}

template <class T, bool kCutOffs>
double FlowLoss<T, kCutOffs>::value(std::span<const BasicSimulationState<T>> frames) const {
  return value_adjoint(frames, 0, {});
}

template <class T, bool kCutOffs>
double FlowLoss<T, kCutOffs>::value_adjoint(std::span<const BasicSimulationState<T>> frames, double adj_value,
                                            std::span<StateGradient<T>> gradient) const {
  double loss = 0;
  for (const auto& pair : seen_.pairs)
    if (total_weight_ > 0 && std::max(pair.from, pair.to) < static_cast<int>(frames.size()))
      loss += of_pair(pair, frames, adj_value, gradient);
  return loss;
}

template class FlowLoss<float, true>;
template class FlowLoss<double, false>;

}  // namespace pliant
