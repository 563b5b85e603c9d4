#pragma once

#include <span>

#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"

namespace pliant {

/// What an AttributeTerm is shown: one picture of the scene with its blended attributes.
struct AttributeView {
  int iteration = 0;
  double progress = 0;  ///< of the training, in [0, 1]
  int photo = 0;        ///< index among the training photos
  const GaussianCloud& cloud;
  std::span<const float> attribute;  ///< y [N, A]
  std::span<const float> shared;
  const ImageF& blended;  ///< [H, W, A] S = W y; H and W may be smaller than the photo's
};

/// Derivatives of the term's loss, to be added to.
struct AttributeGradient {
  ImageF& blended;             ///< [H, W, A]
  std::span<float> attribute;  ///< [N, A] beside what comes through the picture
  std::span<float> shared;
};

/// A further loss on attributes of the Gaussians that are blended like colour; they train along with the scene.
class AttributeTerm {
 public:
  virtual ~AttributeTerm() = default;
  virtual int channels() const = 0;          ///< A, at most 16
  virtual float attribute_rate() const = 0;  ///< Adam's learning rates
  virtual float shared_rate() const = 0;
  /// Starting values of attributes and shared parameters.
  virtual void start(const GaussianCloud& cloud, std::vector<float>& attribute, std::vector<float>& shared) const = 0;
  /// The loss of a picture; adds its derivatives.  A pure function of its arguments.
  virtual double adjoint(const AttributeView& view, AttributeGradient gradient) const = 0;
};

}  // namespace pliant
