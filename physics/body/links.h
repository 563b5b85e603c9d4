#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "gaussians/base/gaussian_cloud.h"
#include "physics/body/driving_particles.h"

namespace pliant {

/// Which samples hang together.  In the bulk, and with it, those that are near each other; in a thin sheet, whose
/// Gaussians show which way it faces, those that are near each other along it: of two leaves that lie closer than their
/// own samples, each hangs together and they do not.
class SampleLinks {
 public:
  /// `cell` is the spacing of the grid that will carry them; both clouds must outlive this.
  SampleLinks(const GaussianCloud& object, const SolidSamples& samples, float cell);

  bool linked(int i, int k) const;
  float reach() const { return reach_; }  ///< no farther samples are linked

 private:
  const SolidSamples& samples_;
  float cell_, reach_, angle_reach_;
  std::vector<Vec3f> normal_;  // [M] of thin sheets, else zero
};

/// Gives the parts of a driver that do not hang together a driver each, so that none lies in two leaves; `linked` says
/// it of two samples.  Returns the number of drivers added.
size_t separate_drivers(const std::function<bool(int, int)>& linked, const SolidSamples& samples,
                        DrivingParticles& drivers);

/// Pairs of drivers whose samples hang together, ascending.  What is one piece by distance alone, samples up to
/// `piece_reach` apart, stays one: where links leave a part of it alone, its shortest gap is closed, and all of them
/// where it is small.
std::vector<std::array<int, 2>> link_drivers(const SampleLinks& links, const SolidSamples& samples, float piece_reach,
                                             const DrivingParticles& drivers);

/// The same for samples that have been given other drivers: those of one driver `before`, and those of two that `links`
/// joined, hang together.  before, after: [M] driver of each sample.
std::vector<std::array<int, 2>> inherited_links(std::span<const int> before, std::span<const std::array<int, 2>> links,
                                                std::span<const int> after);

}  // namespace pliant
