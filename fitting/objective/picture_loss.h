#pragma once

#include <memory>

#include "fitting/objective/drawn_object.h"
#include "fitting/objective/frame_loss.h"
#include "gaussians/render/image_loss.h"

namespace pliant {

/// What a camera saw.
template <class T>
struct SeenFrames {
  Camera camera;
  std::vector<Image<T>> frames;            ///< [T] of the roll-out, the first its start; an empty one is not compared
  std::vector<Image<T>> weight;            ///< [T] of [H, W, 1], or one for all frames, or none: every pixel alike
  std::optional<PictureFrame> frame = {};  ///< the whole picture, where the camera draws a part of one
};

struct PictureLossOptions {
  PhotometricOptions photometric = {0.1, 0.9};  ///< L1 and D-SSIM (PhysDreamer: lambda 0.1)
  double weight_mse = 0;                        ///< of the mean squared difference beside them
};

/// Mean over the compared frames of the difference between what was seen and the drawn object.
template <class T, bool kCutOffs = true>
class PictureLoss : public FrameLoss<T> {
 public:
  PictureLoss(PictureLossOptions options, std::shared_ptr<const DrawnObject<T>> object, SeenFrames<T> seen);

  double value(int frame, const BasicSimulationState<T>& state) const override;
  double value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                       StateGradient<T>& gradient) const override;

 private:
  bool seen(int frame) const { return frame < static_cast<int>(seen_.frames.size()) && !seen_.frames[frame].empty(); }
  const Image<T>& weight(int frame) const;

  PictureLossOptions options_;
  std::shared_ptr<const DrawnObject<T>> object_;
  SeenFrames<T> seen_;
  Image<T> no_weight_;
  int compared_ = 0;
};

extern template class PictureLoss<float, true>;
extern template class PictureLoss<double, true>;
extern template class PictureLoss<double, false>;

}  // namespace pliant
