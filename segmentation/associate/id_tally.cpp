#include "segmentation/associate/id_tally.h"

namespace pliant {

void IdTally::add(int group, uint32_t id, double pixels) {
  all_[id] += pixels;
  if (group < 0) return;
  whole_[group] += pixels;
  by_id_[group][id] += pixels;
}

std::vector<uint32_t> IdTally::kept() const {
  // Two groups cannot both hold most of an id, so that what is kept is one to one.
  std::vector<uint32_t> kept(by_id_.size(), 0);
  for (size_t g = 0; g < by_id_.size(); ++g)
    for (const auto& [id, pixels] : by_id_[g])
      if (2 * pixels > whole_[g] && 2 * pixels > all_.at(id)) kept[g] = id;
  return kept;
}

}  // namespace pliant
