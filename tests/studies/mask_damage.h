#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "gaussians/base/random.h"
#include "segmentation/labels/agreement.h"
#include "segmentation/labels/mask_set.h"

namespace pliant {

/// What makes good masks like those of a program that looks at one photo at a time.
struct MaskDamage {
  bool shuffle = false;        ///< ids are drawn anew in every view
  double missing = 0;          ///< share of masks (an id in a view) that are erased
  double merged_or_split = 0;  ///< share of masks that are merged with a neighbour or cut in two
  uint32_t away = 0;           ///< this id is erased in the middle third of the views
  bool permute = false;        ///< the views come in another order
  uint64_t seed = 5;
};

/// Gives the mask `id` to one that touches it.
inline void merge_with_neighbour(IdImage& ids, uint32_t id, Random random) {
  std::set<uint32_t> near;
  for (int y = 0; y + 1 < ids.height; ++y)
    for (int x = 0; x + 1 < ids.width; ++x)
      for (uint32_t other : {ids(x + 1, y), ids(x, y + 1)}) {
        if (ids(x, y) == id && other != id) near.insert(other);
        if (ids(x, y) != id && other == id) near.insert(ids(x, y));
      }
  near.erase(0);
  if (near.empty()) return;
  const uint32_t other = *std::next(near.begin(), static_cast<std::ptrdiff_t>(random.below(near.size())));
  std::replace(ids.data.begin(), ids.data.end(), id, other);
}

/// Cuts the mask `id` along a line through its middle; one side becomes `fresh`.
inline void split_mask(IdImage& ids, uint32_t id, uint32_t fresh, Random random) {
  double sum_x = 0, sum_y = 0, n = 0;
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (ids(x, y) == id) {
        sum_x += x;
        sum_y += y;
        ++n;
      }
  if (n == 0) return;
  const double angle = random.uniform(0, 6.283185307179586), nx = std::cos(angle), ny = std::sin(angle);
  for (int y = 0; y < ids.height; ++y)
    for (int x = 0; x < ids.width; ++x)
      if (ids(x, y) == id && nx * (x - sum_x / n) + ny * (y - sum_y / n) > 0) ids(x, y) = fresh;
}

inline MaskSet damaged(MaskSet masks, const MaskDamage& damage) {
  for (size_t v = 0; v < masks.views.size(); ++v) {
    IdImage& ids = masks.views[v].ids;
    const uint64_t camera = masks.views[v].camera;
    const std::set<uint32_t> present(ids.data.begin(), ids.data.end());
    uint32_t fresh = 1000000;
    for (uint32_t id : present) {
      if (id == 0) continue;
      Random random(damage.seed, camera, id);
      const double draw = random.uniform();
      if (id == damage.away && v >= masks.views.size() / 3 && v < masks.views.size() * 2 / 3) {
        std::replace(ids.data.begin(), ids.data.end(), id, 0u);
      } else if (draw < damage.missing) {
        std::replace(ids.data.begin(), ids.data.end(), id, 0u);
      } else if (draw < damage.missing + damage.merged_or_split) {
        if (random.uniform() < 0.5)
          merge_with_neighbour(ids, id, random);
        else
          split_mask(ids, id, fresh++, random);
      }
    }
    if (damage.shuffle) {
      std::map<uint32_t, uint32_t> fresh_id;
      std::vector<uint32_t> order;
      for (uint32_t id : std::set<uint32_t>(ids.data.begin(), ids.data.end()))
        if (id != 0) order.push_back(id);
      Random random(damage.seed + 1, camera);
      for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
      for (size_t i = 0; i < order.size(); ++i) fresh_id[order[i]] = static_cast<uint32_t>(i + 1);
      for (uint32_t& id : ids.data)
        if (id != 0) id = fresh_id[id];
    }
  }
  if (damage.permute) {
    Random random(damage.seed + 2);
    for (size_t i = masks.views.size(); i > 1; --i) std::swap(masks.views[i - 1], masks.views[random.below(i)]);
  }
  return masks;
}

/// Predicted id -> true id by overlap.
inline std::map<uint32_t, uint32_t> match_by_overlap(const std::vector<IdImage>& predicted,
                                                     const std::vector<IdImage>& truth) {
  OverlapMatch match;
  for (size_t v = 0; v < truth.size(); ++v) match.add(predicted[v].data, truth[v].data);
  return match.match();
}

/// Predicted pictures with the ids of the truth; what matches nothing becomes 4294967295.
inline std::vector<IdImage> with_true_ids(std::vector<IdImage> predicted, const std::vector<IdImage>& truth) {
  const auto match = match_by_overlap(predicted, truth);
  for (IdImage& ids : predicted)
    for (uint32_t& id : ids.data)
      if (id != 0) id = match.count(id) ? match.at(id) : UINT32_MAX;
  return predicted;
}

}  // namespace pliant
