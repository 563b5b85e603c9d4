#pragma once

#include <vector>

#include "segmentation/associate/footprint.h"

namespace pliant {

struct MaskGraphOptions {
  double divided = 0.5;    ///< a mask that more than this share of its views divide stands on several objects
  double consensus = 0.6;  ///< least share of views, of those that see both, in which joined masks lie in one mask
};

/// Groups of masks that stand on the same object, by what the views agree on (after the view consensus of Yan et al.
/// 2024, MaskClustering): for two masks, a view that sees both speaks for joining them when one of its masks contains
/// both, and against it when two masks do.  Two groups are judged by all pairs of their masks.  Rounds join at once all
/// groups that are each other's best partners, the strongest first, so that no order of masks or views plays a part.
/// group [masks] is numbered by first mask; -1 = the mask stands on several objects.
std::vector<int> group_masks(const MaskGraphOptions& options, const MaskRelations& relations);

}  // namespace pliant
