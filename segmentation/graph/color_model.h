#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussians/base/types.h"

namespace pliant {

/// CIE L*a*b* (D65) divided by 100, of an sRGB colour clamped to [0, 1].
Vec3f lab_of_rgb(const Vec3f& rgb);

struct ColorModelOptions {
  int components = 5;
  float ridge = 1e-3f;         ///< added to the diagonal of every covariance, so that flat colours keep a width
  int rounds = 8;              ///< of expectation and maximisation
  size_t most_samples = 6000;  ///< an even choice of the colours is fitted when there are more
  uint64_t seed = 1;
};

/// Mixture of Gaussians with full covariances over colours (Rother et al. 2004 use it for object and background).
class ColorModel {
 public:
  struct Component {
    float weight = 0;  ///< they add up to 1
    Vec3f mean = Vec3f::Zero();
    Mat3f covariance = Mat3f::Identity();
  };

  /// Maximum likelihood by expectation and maximisation from centres drawn as k-means++ does (Arthur and Vassilvitskii
  /// 2007), or from `start` when it is not empty.  `weights` may be empty.  No colours give an empty model.
  static ColorModel fit(const ColorModelOptions& options, std::span<const Vec3f> colors,
                        std::span<const float> weights = {}, const ColorModel* start = nullptr);

  bool empty() const { return components_.empty(); }
  const std::vector<Component>& components() const { return components_; }
  /// Natural logarithm of the mixture's density; 0 for an empty model.
  float log_density(const Vec3f& color) const;
  std::vector<float> log_density(std::span<const Vec3f> colors) const;

 private:
  struct Evaluated {
    Vec3f mean;
    Mat3f whitening;   ///< L^-1 of covariance = L L^T
    float log_factor;  ///< log of weight and normalisation

    /// Log of the component's share of the density, of one colour or of several.
    template <class Real>
    Real log_density(const Real& x, const Real& y, const Real& z) const;
  };
  void prepare();

  std::vector<Component> components_;
  std::vector<Evaluated> evaluated_;
};

}  // namespace pliant
