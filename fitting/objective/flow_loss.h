#pragma once

#include <memory>

#include "fitting/objective/drawn_object.h"
#include "fitting/objective/frame_loss.h"

namespace pliant {

/// Optical flow that a camera saw between frames of a roll-out.
template <class T>
struct SeenFlow {
  struct Pair {
    int from = 0, to = 0;  ///< frames
    Image<T> flow;         ///< [H, W, 2] px: what is at (x, y) in `from` is at (x, y) + flow(x, y) in `to`
    Image<T> weight;       ///< [H, W, 1]
  };
  Camera camera;
  std::vector<Pair> pairs;
  std::optional<PictureFrame> frame = {};  ///< the whole picture, where the camera draws a part of one
};

/// Mean over pairs and pixels of weight * rho(|seen - drawn|^2), rho as of TrackLoss with d = `outlier` px.  Drawn
/// flow: the way of every Gaussian's centre in the picture, blended as colours are in frame `from`; what stands still
/// has none.
template <class T, bool kCutOffs = true>
class FlowLoss : public RolloutLoss<T> {
 public:
  FlowLoss(std::shared_ptr<const DrawnObject<T>> object, SeenFlow<T> seen, double outlier);

  double value(std::span<const BasicSimulationState<T>> frames) const override;
  double value_adjoint(std::span<const BasicSimulationState<T>> frames, double adj_value,
                       std::span<StateGradient<T>> gradient) const override;

 private:
  double of_pair(const typename SeenFlow<T>::Pair& pair, std::span<const BasicSimulationState<T>> frames,
                 double adj_value, std::span<StateGradient<T>> gradient) const;

  std::shared_ptr<const DrawnObject<T>> object_;
  SeenFlow<T> seen_;
  double outlier_, total_weight_ = 0;
};

extern template class FlowLoss<float, true>;
extern template class FlowLoss<double, false>;

}  // namespace pliant
