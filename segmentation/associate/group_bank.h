#pragma once

#include <span>
#include <vector>

#include "segmentation/associate/associate.h"

namespace pliant {

/// What the groups of masks stand on: each Gaussian's group, and each mask's groups, which follow from one another.
class GroupBank {
 public:
  /// `group` [masks of all views]: first grouping, -1 = none.
  GroupBank(const AssociateOptions& options, size_t gaussians, std::span<const ViewFootprints> views,
            const std::vector<int>& group);

  /// Every Gaussian takes the group with most of its weight, then every mask the groups that it stands on.  False when
  /// nothing changed.
  bool update();

  int groups() const { return groups_; }
  const std::vector<int>& group_of_gaussian() const { return owner_; }  ///< -1 = none
  /// Groups of a mask, by the share of the mask that lies on them; more than one = the mask is to be cut.
  const std::vector<int>& groups_of_mask(size_t view, size_t mask) const { return assigned_[view][mask]; }
  /// Weighted Jaccard index of a mask and a group in that view.
  double overlap(size_t view, size_t mask, int group) const;

 private:
  void take_owners();
  std::vector<int> groups_on(size_t view, size_t mask) const;

  const AssociateOptions& options_;
  std::span<const ViewFootprints> views_;
  int groups_ = 0;
  std::vector<int> owner_;                               ///< [N]
  std::vector<std::vector<std::vector<int>>> assigned_;  ///< [views][masks]
  struct Share {
    int group;
    float mass;
  };
  std::vector<std::vector<std::vector<Share>>> shares_;  ///< [views][masks] of the owners, by group
  std::vector<std::vector<float>> mass_;                 ///< [views][masks] of footprints
  std::vector<std::vector<float>> shown_;                ///< [views][groups] mass of a group in a view
};

}  // namespace pliant
