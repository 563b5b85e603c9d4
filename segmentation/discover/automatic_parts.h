#pragma once

#include <vector>

#include "segmentation/discover/automatic_split.h"
#include "segmentation/discover/automatic_supports.h"

namespace pliant {

struct PartOptions {
  float link = 0.2f;           ///< nearness of Gaussians that lie against each other, see GaussianGraph
  float least_share = 0.001f;  ///< of a picture, mean over the views, that an object shows
  int least_gaussians = 30;
  float reach = 0.2f;  ///< an object's lowest point lies within so much of its height of a support
  SeparateTouchingOptions split;
};

/// What every Gaussian of the scene belongs to.
struct SceneParts {
  static constexpr int kRest = -1;
  struct Part {
    std::vector<int> nodes;  ///< ascending
    double share = 0;        ///< of a picture, mean over the views
    int support = -1;        ///< that it stands on or hangs at; -1 = none
    bool parted = false;     ///< touches another object, from which colours and edges in the views part it
  };
  std::vector<int> object;    ///< [S] index of an object; kRest - 1 - k = support k; kRest = neither
  std::vector<Part> objects;  ///< by share, the largest first
};

/// Objects are connected sets of Gaussians above the supports that stand on one; where there is no support, that show
/// enough.  What touches is parted by split_things.  What shows too little goes to the object or support that it lies
/// against, if there is one; `objects` holds the Gaussians without these.
SceneParts scene_parts(const PartOptions& options, const SolidScene& scene, const std::vector<Support>& supports);

}  // namespace pliant
