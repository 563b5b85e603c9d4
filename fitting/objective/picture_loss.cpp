#include "fitting/objective/picture_loss.h"

#include "gaussians/base/error.h"

namespace pliant {

template <class T, bool kCutOffs>
PictureLoss<T, kCutOffs>::PictureLoss(PictureLossOptions options, std::shared_ptr<const DrawnObject<T>> object,
                                      SeenFrames<T> seen)
    : options_(options), object_(std::move(object)), seen_(std::move(seen)) {
  CHECK(seen_.weight.size() <= 1 || seen_.weight.size() == seen_.frames.size());
  for (const Image<T>& frame : seen_.frames) {
    CHECK(frame.empty() ||
          (frame.width == seen_.camera.width && frame.height == seen_.camera.height && frame.channels == 3));
    compared_ += !frame.empty();
  }
}

template <class T, bool kCutOffs>
const Image<T>& PictureLoss<T, kCutOffs>::weight(int frame) const {
  return seen_.weight.empty() ? no_weight_ : seen_.weight[seen_.weight.size() == 1 ? 0 : frame];
}

template <class T, bool kCutOffs>
double PictureLoss<T, kCutOffs>::value(int frame, const BasicSimulationState<T>& state) const {
  if (!seen(frame)) return 0;
  const Image<T> picture = picture_of<T, kCutOffs>(*object_, seen_.camera, state, seen_.frame);
  const Image<T>& target = seen_.frames[frame];
  double loss = photometric_loss(options_.photometric, picture, target, weight(frame)).total;
  if (options_.weight_mse > 0) loss += options_.weight_mse * mse_loss(picture, target, weight(frame));
  return loss / compared_;
}

template <class T, bool kCutOffs>
double PictureLoss<T, kCutOffs>::value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                                               StateGradient<T>& gradient) const {
  if (!seen(frame)) return 0;
  double loss = 0;
  const Image<T>& target = seen_.frames[frame];
  picture_adjoint<T, kCutOffs>(
      *object_, seen_.camera, state,
      [&](const Image<T>& picture) {
        Image<T> adj;
        loss =
            photometric_loss_adjoint(options_.photometric, picture, target, weight(frame), adj_value / compared_, adj)
                .total;
        if (options_.weight_mse > 0) {
          Image<T> adj_mse;
          loss += options_.weight_mse * mse_loss(picture, target, weight(frame));
          mse_loss_adjoint(picture, target, weight(frame), options_.weight_mse * adj_value / compared_, adj_mse);
          for (size_t i = 0; i < adj.data.size(); ++i) adj.data[i] += adj_mse.data[i];
        }
        return adj;
      },
      gradient, seen_.frame);
  return loss / compared_;
}

template class PictureLoss<float, true>;
template class PictureLoss<double, true>;
template class PictureLoss<double, false>;

}  // namespace pliant
