#pragma once

#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/labels/segmentation.h"

namespace pliant {

struct IslandOptions {
  int neighbours = 12;  ///< of the graph in which parts are connected
  float link = 2.5f;    ///< neighbours with the same label are connected when closer than this many local spacings
  float share = 0.05f;  ///< a part smaller than this share of its label's largest part is an island
  int rounds = 4;       ///< an island may lie inside another one
};

/// Gives small islands of a label that lie against another label to that label, for example the Gaussians on the far
/// side of an object that photos only ever see at its outline, where masks of the background claim them.  Label,
/// attribute and confidence follow.  Islands that touch nothing else are left alone.  Returns how many Gaussians
/// changed.
size_t merge_islands(const IslandOptions& options, const GaussianCloud& cloud, Segmentation& segmentation);

}  // namespace pliant
