#pragma once

#include <functional>
#include <span>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "gaussians/base/image.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

/// How attributes become colours: R, G, B = the first three principal components, each from its 1st to its 99th
/// percentile.
struct PrincipalColors {
  using Axes = Eigen::Matrix<double, kSemanticChannels, 3>;

  /// From samples [n, 16].  Components are ordered by falling variance; a component's sign is the one that gives its
  /// scores a positive third moment, so that colours do not change when the attribute space is rotated or mirrored.
  /// Components without variance are a flat 0.5.
  static PrincipalColors of(std::span<const float> samples);
  Vec3f color(const float* attribute) const;

  Eigen::Matrix<double, kSemanticChannels, 1> mean = Eigen::Matrix<double, kSemanticChannels, 1>::Zero();
  Axes axes = Axes::Zero();
  Vec3d low = Vec3d::Zero(), high = Vec3d::Zero();
};

/// features.png: photos of at most `views` cameras, evenly chosen, and below each the principal components of its
/// blended attribute S, black where accumulated opacity < 0.5; `antialiased` as in Segmentation.  S is rendered no
/// wider than it is shown.  All views share one choice of colours.
ImageF features_sheet(const std::vector<float>& attribute, const GaussianCloud& cloud,
                      const std::vector<Camera>& cameras, const std::function<ImageF(int camera)>& picture,
                      bool antialiased = false, int views = 3);

}  // namespace pliant
