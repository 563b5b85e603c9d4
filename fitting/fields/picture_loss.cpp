#include "fitting/fields/picture_loss.h"

#include "gaussians/base/error.h"

namespace pliant {
namespace {

template <class T>
std::vector<Vec3<T>> in_scene_units(const std::vector<Vec3<T>>& x, double metres_per_unit) {
  std::vector<Vec3<T>> out(x.size());
  for (size_t i = 0; i < x.size(); ++i) out[i] = x[i] / T(metres_per_unit);
  return out;
}

template <class V>
void append(std::vector<V>& to, const std::vector<V>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

template <class T>
CloudOf<T> DrawnObject<T>::at(const BasicSimulationState<T>& state) const {
  CHECK(background.sh_degree == object.sh_degree || background.size() == 0);
  CloudOf<T> moved, all = background;
  deform_as<T>(deform, object, binding, drivers, in_scene_units(state.x, metres_per_unit), state.F, moved);
  all.sh_degree = object.sh_degree;
  append(all.position, moved.position), append(all.rotation, moved.rotation), append(all.log_scale, moved.log_scale);
  append(all.opacity_logit, moved.opacity_logit), append(all.sh, moved.sh);
  return all;
}

template <class T, bool kCutOffs>
PictureLoss<T, kCutOffs>::PictureLoss(PictureLossOptions options, std::shared_ptr<const DrawnObject<T>> object, SeenFrames<T> seen)
    : options_(options), object_(std::move(object)), seen_(std::move(seen)) {
  CHECK(seen_.weight.size() <= 1 || seen_.weight.size() == seen_.frames.size());
  for (const Image<T>& frame : seen_.frames) {
    CHECK(frame.empty() || (frame.width == seen_.camera.width && frame.height == seen_.camera.height && frame.channels == 3));
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
  const Rendered<T> picture = render_as<T, kCutOffs>(object_->at(state), seen_.camera, object_->render);
  const double loss = options_.mse ? mse_loss(picture.color, seen_.frames[frame], weight(frame))
                                   : photometric_loss(options_.photometric, picture.color, seen_.frames[frame], weight(frame)).total;
  return loss / compared_;
}

template <class T, bool kCutOffs>
double PictureLoss<T, kCutOffs>::value_adjoint(int frame, const BasicSimulationState<T>& state, double adj_value,
                                               StateGradient<T>& gradient) const {
  if (!seen(frame)) return 0;
  const CloudOf<T> all = object_->at(state);
  RenderTape<T> tape;
  const Rendered<T> picture = render_as<T, kCutOffs>(all, seen_.camera, object_->render, {}, 0, &tape);
  Rendered<T> adj;
  const Image<T>& target = seen_.frames[frame];
  double loss = 0;
  if (options_.mse) {
    loss = mse_loss(picture.color, target, weight(frame));
    mse_loss_adjoint(picture.color, target, weight(frame), adj_value / compared_, adj.color);
  } else {
    loss = photometric_loss_adjoint(options_.photometric, picture.color, target, weight(frame), adj_value / compared_, adj.color).total;
  }
  GradientExtras extras;
  extras.covariance = true;
  const RenderGradient<T> by = render_adjoint_as<T, kCutOffs>(all, seen_.camera, object_->render, {}, 0, picture, adj, &tape, extras);
  // The object's rows are the last.
  const size_t first = object_->background.size(), first_sh = object_->background.sh.size();
  const DeformGradientOf<T> moved = deform_adjoint<T>(
      object_->deform, object_->object, object_->binding, object_->drivers, in_scene_units(state.x, object_->metres_per_unit), state.F,
      std::span(by.cloud.position).subspan(first), std::span(by.covariance).subspan(first), std::span(by.cloud.sh).subspan(first_sh));
  for (size_t i = 0; i < state.size(); ++i) {
    gradient.x[i] += moved.drivers_now[i] / T(object_->metres_per_unit);
    gradient.F[i] += moved.F[i];
  }
  return loss / compared_;
}

template struct DrawnObject<float>;
template struct DrawnObject<double>;
template class PictureLoss<float, true>;
template class PictureLoss<double, true>;
template class PictureLoss<double, false>;

}  // namespace pliant
