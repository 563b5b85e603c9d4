#pragma once

#include <optional>

#include "fitting/objective/body_points.h"
#include "fitting/objective/frame_loss.h"

namespace pliant {

/// Where points of a body were seen: in the world, or by cameras with one clock.
struct PointTracks {
  std::vector<Vec3f> rest;                  ///< [K, 3] on the body at rest, scene units
  std::optional<Camera> camera;             ///< places are pixels (x, y, 0) of this camera; none: scene units
  std::vector<Camera> further;              ///< cameras beside it
  std::vector<int> camera_of;               ///< [K] 0 = `camera`, i = further[i - 1]; empty = all `camera`
  std::vector<std::vector<Vec3d>> place;    ///< [T][K]; T frames of the roll-out, the first of them its start
  std::vector<std::vector<double>> weight;  ///< [T][K]; 0 = not seen; an empty frame counts as not seen

  /// Coordinates of a place.
  int axes() const { return camera ? 2 : 3; }
};

/// Mean over all seen places of weight * rho(|seen - expected|^2), with the pseudo-Huber function
/// rho(s) = 2 d^2 (sqrt(1 + s / d^2) - 1), which is s for small errors; d = `outlier` in the places' unit.
template <class T>
class TrackLoss : public FrameLoss<T> {
 public:
  TrackLoss(PointTracks tracks, std::span<const Vec3f> drivers, double metres_per_unit, double outlier);

  double value(int frame, const BasicSimulationState<T>& state) const override;
  double value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                       StateGradient<T>& gradient) const override;

  /// The same tracks on a roll-out of which frame lead + every * k shows frame first + k of these; later than `last`
  /// nothing.
  TrackLoss on_rollout(int first, int last, int lead, int every) const;

  const PointTracks& tracks() const { return tracks_; }
  double total_weight() const { return total_weight_; }
  double outlier() const { return outlier_; }
  /// [K] where the points are expected, in the unit of the tracks.
  std::vector<Vec3<T>> expected(const BasicSimulationState<T>& state) const;
  /// Appends the errors of a frame's points, two of each in a picture and three in space: over `noise` and
  /// times the root of its weight; those beyond the outlier distance grow slower, as rho does.  Nothing for a frame
  /// that was not seen.
  void append_errors(int frame, const BasicSimulationState<T>& state, double noise, std::vector<double>& errors) const;
  /// Square root of the mean over all seen places of the frames, of weight * |seen - expected|^2.
  double rms(std::span<const BasicSimulationState<T>> frames) const;

 private:
  bool seen(int frame) const { return frame < static_cast<int>(tracks_.place.size()) && !tracks_.place[frame].empty(); }
  const Camera& camera_of(size_t k) const {
    const int i = tracks_.camera_of.empty() ? 0 : tracks_.camera_of[k];
    return i == 0 ? *tracks_.camera : tracks_.further[i - 1];
  }
  /// Positions in the unit of the tracks.
  std::vector<Vec3<T>> places_of(std::vector<Vec3<T>> positions) const;
  double sum(int frame, const std::vector<Vec3<T>>& expected, std::vector<Vec3<T>>* adj_expected) const;

  void add_weights();

  PointTracks tracks_;
  BodyPoints<T> points_;
  double outlier_, total_weight_ = 0;
};

extern template class TrackLoss<float>;
extern template class TrackLoss<double>;

}  // namespace pliant
