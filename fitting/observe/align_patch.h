#pragma once

#include <Eigen/Core>
#include <vector>

#include "gaussians/base/image.h"

namespace pliant {

/// Colour and its derivatives of a lightly smoothed picture, for sub-pixel sampling.
class GradientPicture {
 public:
  explicit GradientPicture(const ImageF& picture);  ///< [H, W, 3]
  int width() const { return data_.width; }
  int height() const { return data_.height; }
  /// r, g, b, then their derivatives by u, then by v [1/px]; false outside.
  bool sample(double u, double v, float (&out)[9]) const;

 private:
  ImageF data_;  ///< [H, W, 9]
};

/// Where a patch of the first picture lies in another: x -> position + linear (x - centre).
struct PatchWarp {
  Eigen::Vector2d position;
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
};

struct AlignOptions {
  int radius = 10;  ///< px, of the patch; pixels count by a Gaussian of half of it
  int iterations = 15;
  double enough = 0.01;       ///< px, step after which the iteration ends: the next ones are far smaller
  double robust_scale = 0.1;  ///< colour difference at which a pixel counts half
};

struct PatchFit {
  PatchWarp warp;
  double correlation = 0;  ///< of the colours, mean free, in [-1, 1]
  double sigma = 0;  ///< px, error of the position to be expected from what remains of the difference; infinite where
                     ///< texture is missing
  bool inside = false;  ///< most of the patch lies in the picture
};

/// What lies around a point of the first picture.
class Patch {
 public:
  /// Pixels where `mask` [H, W, 1] (may be empty) is 0 do not count.
  Patch(const AlignOptions& options, const GradientPicture& picture, const ImageU8& mask,
        const Eigen::Vector2d& centre);

  /// The warp near `start` under which the patch is most alike, up to a gain and a bias of each colour: Gauss-Newton on
  /// squared differences (Lucas and Kanade 1981; Baker and Matthews 2004), with pixels that differ much counting less.
  PatchFit align(const GradientPicture& picture, const PatchWarp& start) const;

 private:
  struct Pixel {
    Eigen::Vector2d offset;
    float weight;
    float colour[3];
  };
  AlignOptions options_;
  std::vector<Pixel> pixels_;
};

}  // namespace pliant
