#pragma once

#include <span>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "physics/body/samples.h"

namespace pliant {

/// Groups of points that hang together: within each, steps of at most some reach lead from any point to any other.
struct Pieces {
  std::vector<int> piece;      ///< [N] of every point; numbered by falling weight
  std::vector<double> weight;  ///< [pieces] sum of their points'

  size_t size() const { return weight.size(); }
};
Pieces find_pieces(std::span<const Vec3f> points, std::span<const float> weight, float reach);

struct BridgeOptions {
  float step = 0;   ///< samples that are no farther apart hang together
  float reach = 0;  ///< longest gap that is bridged where both sides look alike and face the same way
  float plain = 0;  ///< the same where they do not, and the piece has no gap where they do
};
struct BridgeSummary {
  int bridges = 0;
  size_t samples = 0;  ///< added
};

/// Adds samples across the gaps between pieces that belong together, as the gaps of a leaf that few long Gaussians
/// show: every piece is joined to the nearest other one that is near enough.  Both sides of a gap look and face alike
/// if the Gaussians there have like colours and the gap runs along the surface of both.  Volume is added only where no
/// visible Gaussian lies.
BridgeSummary bridge_gaps(const BridgeOptions& options, const GaussianCloud& object, SolidSamples& samples);

}  // namespace pliant
