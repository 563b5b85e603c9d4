#pragma once

#include "gaussians/render/render.h"

namespace pliant {

/// `RenderResult` in the scalar T.
template <class T>
struct Rendered {
  Image<T> color, depth, alpha, features;
};

/// The pipeline of `render` in the scalar T, from the same float parameters.  kCutOffs = false leaves out the limit on
/// alpha, the smallest alpha and the early end, which makes the picture a smooth function of the parameters.
/// Compiled for <float, true>, <double, true> and <double, false>.
template <class T, bool kCutOffs = true>
Rendered<T> render_as(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options = {},
                      std::span<const float> features = {}, int channels = 0);

}  // namespace pliant
