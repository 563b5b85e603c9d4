#include "fitting/objective/drawn_object.h"

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
  append(all.position, moved.position);
  append(all.rotation, moved.rotation);
  append(all.log_scale, moved.log_scale);
  append(all.opacity_logit, moved.opacity_logit);
  append(all.sh, moved.sh);
  return all;
}

template <class T>
void DrawnObject<T>::at_adjoint(const BasicSimulationState<T>& state, std::span<const Vec3<T>> adj_position,
                                std::span<const Mat3<T>> adj_covariance, std::span<const T> adj_sh,
                                StateGradient<T>& gradient) const {
  // The object's rows are the last.
  const size_t first = background.size();
  const DeformGradientOf<T> by = deform_adjoint<T>(
      deform, object, binding, drivers, in_scene_units(state.x, metres_per_unit), state.F, adj_position.subspan(first),
      adj_covariance.subspan(first), adj_sh.empty() ? adj_sh : adj_sh.subspan(background.sh.size()));
  for (size_t i = 0; i < state.size(); ++i) {
    gradient.x[i] += by.drivers_now[i] / T(metres_per_unit);
    gradient.F[i] += by.F[i];
  }
}

template <class T, bool kCutOffs>
Image<T> picture_of(const DrawnObject<T>& object, const Camera& camera, const BasicSimulationState<T>& state,
                    const std::optional<PictureFrame>& frame) {
  return render_as<T, kCutOffs>(object.at(state), camera, object.render.within(frame)).color;
}

template <class T, bool kCutOffs>
void picture_adjoint(const DrawnObject<T>& object, const Camera& camera, const BasicSimulationState<T>& state,
                     const std::function<Image<T>(const Image<T>&)>& adj_of, StateGradient<T>& gradient,
                     const std::optional<PictureFrame>& frame) {
  const CloudOf<T> all = object.at(state);
  const RenderOptions options = object.render.within(frame);
  RenderTape<T> tape;
  const Rendered<T> picture = render_as<T, kCutOffs>(all, camera, options, {}, 0, &tape);
  Rendered<T> adj;
  adj.color = adj_of(picture.color);
  GradientExtras extras;
  extras.covariance = true;
  const RenderGradient<T> by = render_adjoint_as<T, kCutOffs>(all, camera, options, {}, 0, picture, adj, &tape, extras);
  object.at_adjoint(state, by.cloud.position, by.covariance, by.cloud.sh, gradient);
}

template struct DrawnObject<float>;
template struct DrawnObject<double>;

#define PLIANT_INSTANTIATE(T, kCutOffs)                                                                            \
  template Image<T> picture_of<T, kCutOffs>(const DrawnObject<T>&, const Camera&, const BasicSimulationState<T>&,  \
                                            const std::optional<PictureFrame>&);                                   \
  template void picture_adjoint<T, kCutOffs>(const DrawnObject<T>&, const Camera&, const BasicSimulationState<T>&, \
                                             const std::function<Image<T>(const Image<T>&)>&, StateGradient<T>&,   \
                                             const std::optional<PictureFrame>&);
PLIANT_INSTANTIATE(float, true)
PLIANT_INSTANTIATE(double, true)
PLIANT_INSTANTIATE(double, false)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
