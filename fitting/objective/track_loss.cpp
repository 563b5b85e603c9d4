#include "fitting/objective/track_loss.h"

#include <cmath>

#include "gaussians/base/error.h"

namespace pliant {

template <class T>
TrackLoss<T>::TrackLoss(PointTracks tracks, std::span<const Vec3f> drivers, double metres_per_unit, double outlier)
    : tracks_(std::move(tracks)), points_(tracks_.rest, drivers, metres_per_unit), outlier_(outlier) {
  CHECK(outlier > 0 && (tracks_.camera_of.empty() || tracks_.camera_of.size() == tracks_.rest.size()));
  for (const int i : tracks_.camera_of) CHECK(i >= 0 && i <= static_cast<int>(tracks_.further.size()));
  add_weights();
}

template <class T>
void TrackLoss<T>::add_weights() {
  CHECK(tracks_.place.size() == tracks_.weight.size());
  total_weight_ = 0;
  for (size_t f = 0; f < tracks_.place.size(); ++f) {
    CHECK(tracks_.place[f].empty() ||
          (tracks_.place[f].size() == points_.size() && tracks_.weight[f].size() == points_.size()));
    if (!tracks_.place[f].empty())
      for (const double w : tracks_.weight[f]) total_weight_ += w;
  }
}

template <class T>
TrackLoss<T> TrackLoss<T>::on_rollout(int first, int last, int lead, int every) const {
  CHECK(first >= 0 && last < static_cast<int>(tracks_.place.size()) && lead >= 0 && every > 0);
  TrackLoss out = *this;
  out.tracks_.place.assign(lead + every * (last - first) + 1, {});
  out.tracks_.weight.assign(out.tracks_.place.size(), {});
  for (int f = first; f <= last; ++f) {
    out.tracks_.place[lead + every * (f - first)] = tracks_.place[f];
    out.tracks_.weight[lead + every * (f - first)] = tracks_.weight[f];
  }
  out.add_weights();
  return out;
}

template <class T>
std::vector<Vec3<T>> TrackLoss<T>::places_of(std::vector<Vec3<T>> positions) const {
  if (tracks_.camera)
    for (size_t k = 0; k < positions.size(); ++k) {
      const auto pixel = project_point<T>(camera_of(k), positions[k]);
      positions[k] = Vec3<T>(pixel.x(), pixel.y(), T(0));
    }
  return positions;
}

template <class T>
std::vector<Vec3<T>> TrackLoss<T>::expected(const BasicSimulationState<T>& state) const {
  return places_of(points_.positions(state));
}

template <class T>
double TrackLoss<T>::sum(int frame, const std::vector<Vec3<T>>& expected, std::vector<Vec3<T>>* adj_expected) const {
  double total = 0;
  const double d2 = outlier_ * outlier_;
  for (size_t k = 0; k < expected.size(); ++k) {
    const double weight = tracks_.weight[frame][k] / total_weight_;
    if (!(weight > 0)) continue;
    const Vec3d error = expected[k].template cast<double>() - tracks_.place[frame][k];
    const double root = std::sqrt(1 + error.squaredNorm() / d2);
    total += weight * 2 * d2 * (root - 1);
    if (adj_expected) (*adj_expected)[k] = (weight * 2 / root * error).template cast<T>();
  }
  return total;
}

template <class T>
double TrackLoss<T>::value(int frame, const BasicSimulationState<T>& state) const {
  return seen(frame) && total_weight_ > 0 ? sum(frame, expected(state), nullptr) : 0;
}

template <class T>
double TrackLoss<T>::value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                                   StateGradient<T>& gradient) const {
  if (!seen(frame) || !(total_weight_ > 0)) return 0;
  const std::vector<Vec3<T>> position = points_.positions(state);
  const std::vector<Vec3<T>> expected = places_of(position);
  std::vector<Vec3<T>> adj(position.size(), Vec3<T>::Zero());
  const double total = sum(frame, expected, &adj);
  for (size_t k = 0; k < adj.size(); ++k) {
    adj[k] *= T(adj_value);
    if (tracks_.camera) adj[k] = project_point_adjoint<T>(camera_of(k), position[k], adj[k].template head<2>());
  }
  points_.positions_adjoint(state, adj, gradient);
  return total;
}

template <class T>
void TrackLoss<T>::append_errors(int frame, const BasicSimulationState<T>& state, double noise,
                                 std::vector<double>& errors) const {
  if (!seen(frame)) return;
  const std::vector<Vec3<T>> places = expected(state);
  const double d2 = outlier_ * outlier_;
  for (size_t k = 0; k < places.size(); ++k) {
    Vec3d error = places[k].template cast<double>() - tracks_.place[frame][k];
    const double s = error.squaredNorm(), weight = tracks_.weight[frame][k];
    if (s > 0) error *= std::sqrt(2 * d2 * (std::sqrt(1 + s / d2) - 1) / s);
    error *= weight > 0 ? std::sqrt(weight) / noise : 0;
    for (int a = 0; a < tracks_.axes(); ++a) errors.push_back(error[a]);
  }
}

template <class T>
double TrackLoss<T>::rms(std::span<const BasicSimulationState<T>> frames) const {
  double total = 0, weights = 0;
  for (size_t f = 0; f < frames.size() && f < tracks_.place.size(); ++f) {
    if (tracks_.place[f].empty()) continue;
    const std::vector<Vec3<T>> places = expected(frames[f]);
    for (size_t k = 0; k < places.size(); ++k) {
      total += tracks_.weight[f][k] * (places[k].template cast<double>() - tracks_.place[f][k]).squaredNorm();
      weights += tracks_.weight[f][k];
    }
  }
  return weights > 0 ? std::sqrt(total / weights) : 0;
}

template class TrackLoss<float>;
template class TrackLoss<double>;

}  // namespace pliant
