#pragma once

#include <optional>
#include <span>
#include <vector>

#include "gaussians/base/nearest.h"

namespace pliant {

/// A strand that is one Gaussian thick, where one of its Gaussians lies.
struct Strand {
  Vec3f along;      ///< along it, as long as one standard deviation of the Gaussian
  Vec3f across[2];  ///< principal axes of its cross-section, each as long as one standard deviation
  float length;     ///< of the strand that the Gaussian stands for: what lies between Gaussians is no part of it

  /// Of the round rod whose cross-section has the area of the uniform ellipse with these standard deviations.
  float diameter() const;
};

/// The strand that point `i` lies in, from its `hits`, the nearest points and itself: these form a line, their
/// Gaussians are not flat, and nothing else is as near to it as its own thickness.
std::optional<Strand> strand_at(int i, std::span<const Vec3f> position, std::span<const Mat3f> covariance,
                                const NearestPoints& tree, const std::vector<NearestPoints::Hit>& hits);

}  // namespace pliant
