#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gaussians/base/camera.h"
#include "gaussians/base/gaussian_cloud.h"
#include "segmentation/associate/footprint.h"
#include "segmentation/associate/mask_graph.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// Association of masks whose ids hold only inside their own view.
struct AssociateOptions {
  FootprintOptions footprint;
  RelationOptions relation;
  MaskGraphOptions graph;
  int rounds = 4;             ///< of assigning masks to groups and groups to Gaussians, at most
  float single = 0.7f;        ///< a mask with this share of its footprint on one group belongs to it ...
  float covered = 0.5f;       ///< ... unless it also covers this share of what the view shows of another group,
  float part = 0.02f;         ///< which is at least this share of the mask
  float sure = 0.6f;          ///< of a pixel's weight, on one group, when a mask on several groups is cut along them
  double keep_above = 2;      ///< masks whose ids agree between views at more than this share are kept as they are
  int judged_views = 12;      ///< views, spread evenly, by which that is judged; what is below is judged by all
  std::vector<int> held_out;  ///< cameras whose masks are never looked at
  std::function<void()> under_way = {};  ///< called before each view that is looked at; may throw
};

struct AssociateSummary {
  bool associated = true;  ///< false = the ids were good enough, see AssociateOptions::keep_above
  int views = 0, masks = 0, groups = 0;
  int merged = 0;          ///< masks on several groups, cut along them
  int split = 0;           ///< masks that share their group with another mask of the same view
  int ignored = 0;         ///< masks without a footprint of their own, set to 0
  int kept_ids = 0;        ///< groups that keep the id which most of them carried
  int reused_ids = 0;      ///< groups with a new id that other masks carried
  double consistency = 1;  ///< of the ids that came in, see id_consistency
  double overlap = 0;      ///< mean weighted Jaccard index of masks, but for merged and split ones, with their groups

  std::string describe() const;
};

struct AssociateResult {
  MaskSet masks;  ///< the views that are not held out, in the given order, with ids that hold in all of them
  AssociateSummary summary;
};

/// Ids that hold in all views, from what the masks' footprints on Gaussians have in common; the number of ids is not
/// limited, and an object that leaves and comes back keeps its id.  Masks are grouped by the consensus of all views
/// (group_masks); every Gaussian then takes the group that holds most of its weight over all views (the memory bank),
/// and all masks are assigned anew by their overlap with the groups, until nothing changes.  A mask that covers several
/// groups is cut along them, several masks of one view may belong to one group, and unlabelled pixels say nothing.
/// Every step treats all views alike: the result does not depend on the order of views or of ids inside a view.
/// A group keeps an id that carries most of it and lies mostly in it; others are numbered by free_id.
AssociateResult associate(const AssociateOptions& options, const GaussianCloud& cloud,
                          const std::vector<Camera>& cameras, const MaskSet& masks);

}  // namespace pliant
