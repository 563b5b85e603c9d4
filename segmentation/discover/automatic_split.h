#pragma once

#include <vector>

#include "segmentation/discover/automatic_surface.h"

namespace pliant {

struct SeparateTouchingOptions {
  float seed = 0.7f;  ///< agreement from which on neighbours make a seed
  float agreement =
      0.5f;             ///< two things differ when the views join less than this share of what lies against each other
  float color = 0.12f;  ///< and their mean colours are so far apart (Lab / 100),
  float lightness = 0.5f;      ///< with this factor on L
  float least_share = 0.001f;  ///< of a picture, that each must show
};

/// Sums over a set of Gaussians.
struct GroupSums {
  double share = 0, volume = 0, weight = 0;
  Vec3d lab = Vec3d::Zero();
  int feet = 0;
  void add(const GroupSums& other);
  Vec3d mean_lab() const { return weight > 0 ? Vec3d(lab / weight) : lab; }
};
GroupSums sums_of(const SolidScene& scene, int i);

/// What ties two sets of Gaussians: sums over the edges between them.
struct GroupBorder {
  double nearness = 0, agreement = 0;  ///< the second one: nearness times agreement
};

/// Whether two groups that touch are different things by the views and by colour.
bool distinct(const SeparateTouchingOptions& options, const GroupSums& a, const GroupSums& b,
              const GroupBorder& border);

/// Parts a connected set of Gaussians (`nodes`, ascending places in the scene) into things that stand by themselves:
/// Gaussians that the views join make small seeds; these grow together, the strongest tie for the smaller one's size
/// first, but two that have feet (`foot` [S] != 0) and are distinct never do.  What has no feet always finds something
/// to belong to.  Returns the group of every node, by first node.
std::vector<int> split_things(const SeparateTouchingOptions& options, const SolidScene& scene,
                              const std::vector<int>& nodes, const std::vector<uint8_t>& foot);

}  // namespace pliant
