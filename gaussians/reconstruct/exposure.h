#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// What the exposure and white balance of one photo do to colours: an affine map [3, 4], row-major, colour ->
/// M (r, g, b, 1)^T (the exposure compensation of the reference 3DGS code).
inline constexpr int kExposureSize = 12;
inline constexpr float kNeutralExposure[kExposureSize] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

template <class T>
Image<T> expose(const Image<T>& color, const T* exposure);

/// Turns dL/dexposed into dL/dcolor in place and adds dL/dexposure [12] to `adj_exposure`.  Equal bit for bit for any
/// number of threads.
template <class T>
void expose_adjoint(const Image<T>& color, const T* exposure, Image<T>& adj, T* adj_exposure);

}  // namespace pliant
