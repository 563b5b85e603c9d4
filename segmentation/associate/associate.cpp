#include "segmentation/associate/associate.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>

#include "gaussians/base/error.h"
#include "segmentation/associate/group_bank.h"
#include "segmentation/associate/id_tally.h"

namespace pliant {
namespace {

/// Footprints of the views that are still missing among `order`.
void add_footprints(const AssociateOptions& options, const GaussianCloud& cloud, const std::vector<Camera>& cameras,
                    const MaskSet& masks, std::span<const size_t> order, std::map<size_t, ViewFootprints>& views) {
  for (size_t v : order)
    if (!views.count(v)) {
      if (options.under_way) options.under_way();
      views[v] = footprints(options.footprint, cloud, cameras[masks.views[v].camera], masks.views[v]);
    }
}

/// Agreement of the ids between some views, spread evenly.
double judged_consistency(const AssociateOptions& options, const GaussianCloud& cloud,
                          const std::vector<Camera>& cameras, const MaskSet& masks, const std::vector<size_t>& order,
                          std::map<size_t, ViewFootprints>& views) {
  const size_t count = std::min<size_t>(std::max(2, options.judged_views), order.size());
  std::vector<size_t> judged;
  for (size_t k = 0; k < count; ++k) judged.push_back(order[k * order.size() / count]);
  add_footprints(options, cloud, cameras, masks, judged, views);
  std::vector<ViewFootprints> some;
  for (size_t v : judged) some.push_back(views[v]);
  return id_consistency(relate(options.relation, some), some);
}

/// Pixels of the ids in the groups that hold their masks alone.
IdTally tally_of(const GroupBank& bank, const std::vector<ViewFootprints>& views) {
  IdTally tally(bank.groups());
  for (size_t v = 0; v < views.size(); ++v)
    for (size_t m = 0; m < views[v].masks(); ++m) {
      const std::vector<int>& groups = bank.groups_of_mask(v, m);
      tally.add(groups.size() == 1 ? groups[0] : -1, views[v].id[m], views[v].pixels[m]);
    }
  return tally;
}

/// Ids of the groups that hold a mask, those that they keep among them; 0 for those that lost all of theirs.
std::vector<uint32_t> ids_of_groups(const IdTally& tally, const std::vector<uint32_t>& kept) {
  std::vector<uint32_t> id = kept;
  std::set<uint32_t> used(kept.begin(), kept.end());
  std::vector<int> by_size(kept.size());
  std::iota(by_size.begin(), by_size.end(), 0);
  std::stable_sort(by_size.begin(), by_size.end(), [&](int a, int b) { return tally.whole(a) > tally.whole(b); });
  for (int g : by_size) {
    if (tally.whole(g) == 0 || id[g] != 0) continue;
    id[g] = free_id(used);
    used.insert(id[g]);
  }
  return id;
}

/// Pixels of masks that stand on several groups, by the group with most of the pixel's weight; 0 where that is not
/// sure.
void cut_merged(const AssociateOptions& options, const GaussianCloud& cloud, const Camera& camera,
                const GroupBank& bank, size_t v, const std::vector<int>& mask, const std::vector<uint32_t>& id,
                IdImage& out) {
  const BlendWeights weights = blend_weights(cloud, camera, options.footprint.render);
  const std::vector<int>& owner = bank.group_of_gaussian();
  parallel_for(
      static_cast<std::ptrdiff_t>(mask.size()),
      [&](std::ptrdiff_t pixel) {
        if (mask[pixel] < 0 || bank.groups_of_mask(v, mask[pixel]).size() < 2) return;
        const std::vector<int>& groups = bank.groups_of_mask(v, mask[pixel]);
        std::vector<float> on(groups.size(), 0.0f);
        float total = 0;
        for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) {
          const auto it = std::find(groups.begin(), groups.end(), owner[weights.gaussian[e]]);
          if (it != groups.end()) on[it - groups.begin()] += weights.weight[e];
          total += weights.weight[e];
        }
        const auto most = std::max_element(on.begin(), on.end());
        out.data[pixel] = *most > options.sure * total ? id[groups[most - on.begin()]] : 0;
      },
      1024);
}

}  // namespace

AssociateResult associate(const AssociateOptions& options, const GaussianCloud& cloud,
                          const std::vector<Camera>& cameras, const MaskSet& masks) {
  AssociateResult result;
  AssociateSummary& summary = result.summary;
  const std::vector<size_t> order = used_views(options.held_out, cameras, masks);
  std::map<size_t, ViewFootprints> found;
  if (options.keep_above <= 1) {
    summary.consistency = judged_consistency(options, cloud, cameras, masks, order, found);
    if (summary.consistency > options.keep_above) {
      summary.associated = false;
      summary.views = static_cast<int>(order.size());
      result.masks.names = masks.names;
      result.masks.warnings = masks.warnings;
      for (size_t v : std::set<size_t>(order.begin(), order.end())) result.masks.views.push_back(masks.views[v]);
      return result;
    }
  }
  add_footprints(options, cloud, cameras, masks, order, found);
  std::vector<ViewFootprints> views;
  for (size_t v : order) views.push_back(std::move(found[v]));
  const MaskRelations relations = relate(options.relation, views);
  summary.views = static_cast<int>(views.size());
  summary.masks = relations.masks();
  summary.consistency = id_consistency(relations, views);
  GroupBank bank(options, cloud.size(), views, group_masks(options.graph, relations));
  for (int round = 0; round < options.rounds && bank.update(); ++round) {
  }

  const IdTally tally = tally_of(bank, views);
  const std::vector<uint32_t> kept = tally.kept(), id = ids_of_groups(tally, kept);
  summary.groups = static_cast<int>(id.size() - std::count(id.begin(), id.end(), 0));
  summary.kept_ids = static_cast<int>(kept.size() - std::count(kept.begin(), kept.end(), 0));
  const std::vector<uint32_t> carried = masks.ids();
  for (size_t g = 0; g < id.size(); ++g)
    summary.reused_ids += kept[g] == 0 && std::binary_search(carried.begin(), carried.end(), id[g]);
  std::vector<MaskSet::View> relabelled(masks.views.size());
  int clean = 0;
  for (size_t v = 0; v < views.size(); ++v) {
    if (options.under_way) options.under_way();
    const MaskSet::View& in = masks.views[order[v]];
    MaskSet::View& out = relabelled[order[v]];
    out = {in.camera, IdImage(in.ids.width, in.ids.height, 1)};
    std::vector<uint32_t> unused;
    const std::vector<int> mask = masks_of_pixels(in.ids, unused);
    std::map<int, int> times;  // masks of this view on one group
    for (size_t m = 0; m < views[v].masks(); ++m)
      if (const auto& groups = bank.groups_of_mask(v, m); groups.size() == 1) ++times[groups[0]];
    bool cut = false;
    for (size_t m = 0; m < views[v].masks(); ++m) {
      const std::vector<int>& groups = bank.groups_of_mask(v, m);
      cut = cut || groups.size() > 1;
      summary.merged += groups.size() > 1;
      summary.ignored += groups.empty();
      if (groups.size() != 1) continue;
      if (times[groups[0]] > 1)
        ++summary.split;
      else {
        summary.overlap += bank.overlap(v, m, groups[0]);
        ++clean;
      }
    }
    for (size_t pixel = 0; pixel < mask.size(); ++pixel)
      if (mask[pixel] >= 0 && bank.groups_of_mask(v, mask[pixel]).size() == 1)
        out.ids.data[pixel] = id[bank.groups_of_mask(v, mask[pixel])[0]];
    if (cut) cut_merged(options, cloud, cameras[in.camera], bank, v, mask, id, out.ids);
  }
  if (clean > 0) summary.overlap /= clean;
  for (const auto& [old, name] : masks.names)
    if (std::count(kept.begin(), kept.end(), old)) result.masks.names[old] = name;
  result.masks.warnings = masks.warnings;
  const std::set<size_t> used(order.begin(), order.end());
  for (size_t v : used) result.masks.views.push_back(std::move(relabelled[v]));
  return result;
}

std::string AssociateSummary::describe() const {
  char text[400];
  if (!associated) {
    std::snprintf(text, sizeof(text), "IDs agree across views at %.0f %% and are kept", 100 * consistency);
    return text;
  }
  std::snprintf(text, sizeof(text),
                "%d masks in %d views belong to %d objects, %d of which keep an input ID; %d masks on several objects "
                "were cut, %d are parts of one object, %d are on no object and were ignored; mean overlap of masks "
                "with their objects %.2f; input IDs agree across views at %.0f %%",
                masks, views, groups, kept_ids, merged, split, ignored, overlap, 100 * consistency);
  return text;
}

}  // namespace pliant
