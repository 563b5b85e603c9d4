#pragma once

#include "gaussians/base/image.h"

namespace pliant {

// Losses between two images of the same size, values in [0, 1], and their derivatives with respect to the first one.
// `weight` [H, W, 1] says how much each pixel counts in a mean; empty = all alike.  Where no pixel counts, losses and
// derivatives are 0.  Compiled for float and double; sums are in double, and everything is equal bit for bit for any
// number of threads.  Adjoints write `adj_a` [H, W, C], the derivative of the loss times `adj_loss`.

/// Mean absolute difference; its derivative where values are equal is 0.
template <class T>
double l1_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight = {});
template <class T>
void l1_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a);

/// Mean squared difference.
template <class T>
double mse_loss(const Image<T>& a, const Image<T>& b, const Image<T>& weight = {});
template <class T>
void mse_loss_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, double adj_loss, Image<T>& adj_a);

/// Peak signal-to-noise ratio of a mean squared difference, peak 1 (dB); infinite for 0.
double psnr_of_mse(double mse);

/// Which windows count in the mean: those around every pixel, the image continued by zeros (the reference 3DGS code),
/// or only those that lie inside the image, which must be at least 11 x 11 (Wang et al. 2004).
enum class SsimWindows { kEveryPixel, kInside };

/// What a pixel of weight 0 is to the windows of SSIM around other pixels.
enum class ZeroWeight {
  kUncounted,  ///< one like any other: only the window around it does not count
  kUnknown     ///< nothing: the means of a window are those of its other pixels, and the pixel's derivative is 0
};

/// Structural similarity (Wang et al. 2004, eq. 13): Gaussian window 11 x 11, sigma 1.5, C1 = 0.01^2, C2 = 0.03^2,
/// mean over windows and channels.  D-SSIM is 1 - SSIM.
template <class T>
double ssim(const Image<T>& a, const Image<T>& b, const Image<T>& weight = {},
            SsimWindows windows = SsimWindows::kEveryPixel, ZeroWeight zero = ZeroWeight::kUncounted);
/// With ZeroWeight::kUncounted.
template <class T>
void ssim_adjoint(const Image<T>& a, const Image<T>& b, const Image<T>& weight, SsimWindows windows, double adj_ssim,
                  Image<T>& adj_a);

struct PhotometricOptions {
  double weight_l1 = 0.8, weight_dssim = 0.2;  ///< of the reference 3DGS code
  ZeroWeight zero_weight = ZeroWeight::kUncounted;
};

struct PhotometricLoss {
  double l1 = 0, dssim = 0;
  double total = 0;  ///< weight_l1 l1 + weight_dssim dssim
};

/// Both losses in one pass over the images.
template <class T>
PhotometricLoss photometric_loss(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                 const Image<T>& weight = {});
/// Derivative of `total`; returns the loss too, from the same pass.
template <class T>
PhotometricLoss photometric_loss_adjoint(const PhotometricOptions& options, const Image<T>& a, const Image<T>& b,
                                         const Image<T>& weight, double adj_total, Image<T>& adj_a);

}  // namespace pliant
