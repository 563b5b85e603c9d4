#pragma once

#include "gaussians/base/image.h"

namespace pliant {

/// Least width and height for five scales of windows of 11 px.
constexpr int kLeastMsSsimSize = 176;

/// Multi-scale structural similarity (Wang, Simoncelli, Bovik 2003): contrast and structure at five scales, each half
/// as fine, luminance at the coarsest, with the exponents .0448 .2856 .3001 .2363 .1333 of their section 3.2.  Gaussian
/// window 11 x 11, sigma 1.5, windows inside the picture, C1 = 0.01^2, C2 = 0.03^2 for values in [0, 1]; means of 2 x 2
/// pixels between scales; a scale whose mean is negative counts as 0.  Mean over the channels.  Pictures of one size,
/// at least kLeastMsSsimSize wide and high.
double ms_ssim(const Image<double>& a, const Image<double>& b);

}  // namespace pliant
