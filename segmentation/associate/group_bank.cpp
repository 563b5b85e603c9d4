#include "segmentation/associate/group_bank.h"

#include <algorithm>
#include <map>

#include "gaussians/base/portable.h"

namespace pliant {

GroupBank::GroupBank(const AssociateOptions& options, size_t gaussians, std::span<const ViewFootprints> views,
                     const std::vector<int>& group)
    : options_(options), views_(views), owner_(gaussians, -1) {
  size_t next = 0;
  for (const ViewFootprints& view : views) {
    auto& masks = assigned_.emplace_back(view.masks());
    for (auto& mask : masks) {
      if (group[next] >= 0) {
        mask.push_back(group[next]);
        groups_ = std::max(groups_, group[next] + 1);
      }
      ++next;
    }
    auto& mass = mass_.emplace_back(view.masks(), 0.0f);
    for (size_t e = 0; e < view.gaussian.size(); ++e)
      if (view.mask[e] >= 0) mass[view.mask[e]] += view.mass[e];
  }
  shares_.resize(views.size());
  shown_.resize(views.size());
}

void GroupBank::take_owners() {
  // Masks on one group vote with their footprints.  Views are visited in turn, so a Gaussian's sums have one order.
  struct Vote {
    int group;
    float mass;
  };
  std::vector<std::vector<Vote>> votes(owner_.size());
  for (size_t v = 0; v < views_.size(); ++v) {
    const ViewFootprints& view = views_[v];
    parallel_for(
        static_cast<std::ptrdiff_t>(view.gaussian.size()),
        [&](std::ptrdiff_t e) {
          if (view.mask[e] < 0 || assigned_[v][view.mask[e]].size() != 1) return;
          const int group = assigned_[v][view.mask[e]][0];
          std::vector<Vote>& own = votes[view.gaussian[e]];
          const auto it = std::find_if(own.begin(), own.end(), [&](const Vote& vote) { return vote.group == group; });
          if (it != own.end())
            it->mass += view.mass[e];
          else
            own.push_back({group, view.mass[e]});
        },
        4096);
  }
  parallel_for(
      static_cast<std::ptrdiff_t>(owner_.size()),
      [&](std::ptrdiff_t p) {
        const auto most = std::max_element(votes[p].begin(), votes[p].end(), [](const Vote& a, const Vote& b) {
          return a.mass != b.mass ? a.mass < b.mass : a.group > b.group;
        });
        owner_[p] = most == votes[p].end() ? -1 : most->group;
      },
      4096);
}

std::vector<int> GroupBank::groups_on(size_t v, size_t m) const {
  std::vector<Share> shares = shares_[v][m];
  std::sort(shares.begin(), shares.end(),
            [](const Share& a, const Share& b) { return a.mass != b.mass ? a.mass > b.mass : a.group < b.group; });
  if (shares.empty() || !(mass_[v][m] > 0)) return {};
  std::vector<int> groups{shares[0].group};
  const bool single = shares[0].mass >= options_.single * mass_[v][m];
  for (size_t s = 1; s < shares.size(); ++s) {
    const bool covers = shares[s].mass >= options_.covered * shown_[v][shares[s].group];
    if (shares[s].mass >= options_.part * mass_[v][m] && (covers || (!single && shares[s].mass >= 0.1f * mass_[v][m])))
      groups.push_back(shares[s].group);
  }
  return groups;
}

bool GroupBank::update() {
  take_owners();
  std::vector<uint8_t> changed(views_.size(), 0);
  parallel_for(static_cast<std::ptrdiff_t>(views_.size()), [&](std::ptrdiff_t v) {
    const ViewFootprints& view = views_[v];
    shown_[v].assign(groups_, 0.0f);
    std::vector<std::map<int, float>> mass(view.masks());
    for (size_t e = 0; e < view.gaussian.size(); ++e) {
      const int group = owner_[view.gaussian[e]];
      if (group < 0) continue;
      shown_[v][group] += view.mass[e];
      if (view.mask[e] >= 0) mass[view.mask[e]][group] += view.mass[e];
    }
    shares_[v].assign(view.masks(), {});
    for (size_t m = 0; m < view.masks(); ++m) {
      for (const auto& [group, sum] : mass[m]) shares_[v][m].push_back({group, sum});
      std::vector<int> groups = groups_on(v, m);
      changed[v] |= groups != assigned_[v][m];
      assigned_[v][m] = std::move(groups);
    }
  });
  return std::find(changed.begin(), changed.end(), 1) != changed.end();
}

double GroupBank::overlap(size_t view, size_t mask, int group) const {
  for (const Share& share : shares_[view][mask])
    if (share.group == group) return share.mass / (mass_[view][mask] + shown_[view][group] - share.mass);
  return 0;
}

}  // namespace pliant
