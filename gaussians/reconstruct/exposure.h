#pragma once

#include <array>

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

/// The exposure that makes `color` most like `target` in the least squares; `weight` [H, W, 1] may be empty.
std::array<float, kExposureSize> fit_exposure(const ImageF& color, const ImageF& target, const ImageF& weight);

}  // namespace pliant
