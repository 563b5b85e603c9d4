#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// Association as in Gaga (Lyu et al. 2024), re-created from its paper and the behaviour of its released program, for
/// comparison: by Gaussians' centres, view after view.  Not re-created: its limit of 255 ids.
struct GagaOptions {
  int patches = 32;           ///< along each side of a picture
  float front = 0.2f;         ///< share of the centres of a mask in a patch, the nearest ones, that count; at least one
  float overlap = 0.1f;       ///< least score at which a mask joins a group
  std::vector<int> held_out;  ///< cameras whose masks are never looked at
  std::function<void()> under_way = {};  ///< called before each view that is looked at; may throw
};

struct GagaSummary {
  int views = 0, masks = 0, groups = 0;

  std::string describe() const;
};

struct GagaResult {
  MaskSet masks;  ///< the views that are not held out, in the given order; ids are the groups' numbers from 1 on
  GagaSummary summary;
};

/// A mask stands on the front centres that project into it.  It joins the group with the largest
/// common / (own + common), counted in Gaussians, and gives it those that are in no group yet; below `overlap` it
/// begins a group.  Views follow one another by the names of their cameras, masks by their first pixels; what comes
/// first decides.  A group has the name of its first mask.
GagaResult associate_by_centres(const GagaOptions& options, const GaussianCloud& cloud,
                                const std::vector<Camera>& cameras, const MaskSet& masks);

}  // namespace pliant
