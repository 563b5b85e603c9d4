#pragma once

#include "gaussians/render/render.h"

namespace pliant {

/// `render` in the scalar T.  kCutOffs = false leaves out the limit on alpha, the smallest alpha and the early end,
/// which makes the picture a smooth function of the parameters.
/// Compiled for <float, true>, <double, true> and <double, false>.
template <class T, bool kCutOffs = true>
Rendered<T> render_as(const CloudOf<T>& cloud, const Camera& camera, const RenderOptions& options = {},
                      std::span<const T> features = {}, int channels = 0, RenderTape<T>* tape = nullptr);

/// `render_adjoint` in the scalar T.
template <class T, bool kCutOffs = true>
RenderGradient<T> render_adjoint_as(const CloudOf<T>& cloud, const Camera& camera, const RenderOptions& options,
                                    std::span<const T> features, int channels, const Rendered<T>& picture,
                                    const Rendered<T>& adj, const RenderTape<T>* tape = nullptr,
                                    const GradientExtras& extras = {});

}  // namespace pliant
