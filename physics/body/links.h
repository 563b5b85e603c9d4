#pragma once

#include <array>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "physics/body/driving_particles.h"

namespace pliant {

/// Which samples hang together.  In the bulk those that are near each other; in a thin sheet, whose Gaussians show
/// which way it faces, those that are near each other along it: of two leaves that lie closer than their own samples,
/// each hangs together and they do not.
class SampleLinks {
 public:
  /// `cell` is the spacing of the grid that will carry them; both clouds must outlive this.
  SampleLinks(const GaussianCloud& object, const SolidSamples& samples, float cell);

  bool linked(int i, int k) const;
  float reach() const { return reach_; }  ///< no farther samples are linked

 private:
  const SolidSamples& samples_;
  float cell_, reach_, bulk_;
  std::vector<Vec3f> normal_;  // [M] of thin sheets, else zero
};

/// Gives the parts of a driver that do not hang together a driver each, so that none lies in two leaves.  Returns the
/// number of drivers added.
size_t separate_drivers(const SampleLinks& links, const SolidSamples& samples, DrivingParticles& drivers);

/// Pairs of drivers whose samples hang together, ascending.  What is one piece by distance alone, samples up to
/// `piece_reach` apart, stays one: where links leave a part of it alone, its shortest gap is closed.
std::vector<std::array<int, 2>> link_drivers(const SampleLinks& links, const SolidSamples& samples, float piece_reach,
                                             const DrivingParticles& drivers);

}  // namespace pliant
