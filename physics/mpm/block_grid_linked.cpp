// Nodes of a body whose parts lie near each other without hanging together.

#include <map>
#include <numeric>

#include "gaussians/base/disjoint_sets.h"
#include "physics/mpm/block_grid.h"

namespace pliant {
namespace {

using Place = std::array<int, 3>;

}  // namespace

void BlockGrid::build_linked(std::span<const Coordinates> block_of_particle, std::span<const Link> links) {
  const size_t n = block_of_particle.size();
  DisjointSets hang(n);
  for (const auto& [i, k] : links)
    if (block_of_particle[i] == block_of_particle[k]) hang.join(i, k);
  // Parts of a block are numbered as they appear.
  std::vector<Coordinates> part(block_of_particle.begin(), block_of_particle.end());
  std::map<Place, int> parts;
  for (size_t i = 0; i < n; ++i) {
    const int first = hang.find(static_cast<int>(i));
    const Coordinates& c = part[i];
    part[i].object = first == static_cast<int>(i) ? parts[Place{c.x, c.y, c.z}]++ : part[first].object;
  }
  build(part);
  linked_ = true;

  // The objects, whose place the numbers of the parts took.
  linked_object_.resize(particle_blocks());
  for (int b = 0; b < particle_blocks(); ++b) linked_object_[b] = block_of_particle[order_[begin_[b]]].object;
  std::vector<int> block(n);
  for (int b = 0; b < particle_blocks(); ++b)
    for (int s = begin_[b]; s < begin_[b + 1]; ++s) block[order_[s]] = b;
  std::vector<std::array<int, 2>> joined;
  for (const auto& [i, k] : links)
    if (block[i] != block[k]) joined.push_back({std::min(block[i], block[k]), std::max(block[i], block[k])});
  std::sort(joined.begin(), joined.end());
  joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
  share_nodes(joined);
}

/// Gives each set of blocks that are joined among those around a place node blocks of its own there.
void BlockGrid::share_nodes(const std::vector<std::array<int, 2>>& joined) {
  struct Touch {
    int block, offset;
  };
  std::map<Place, std::vector<Touch>> around;
  for (int b = 0; b < particle_blocks(); ++b)
    for (int o = 0; o < 8; ++o)
      around[{block_[b].x + (o >> 2), block_[b].y + (o >> 1 & 1), block_[b].z + (o & 1)}].push_back({b, o});

  node_block_.clear();
  node_links_.clear();
  further_links_.clear();
  further_begin_.assign(1, 0);
  node_table_.clear(1);
  has_siblings_ = false;
  constexpr std::array<int, 8> kNone = {-1, -1, -1, -1, -1, -1, -1, -1};
  for (const auto& [place, touches] : around) {
    DisjointSets sets(touches.size());
    for (size_t t = 0; t < touches.size(); ++t)
      for (size_t u = 0; u < t; ++u)
        if (std::binary_search(joined.begin(), joined.end(), std::array{touches[u].block, touches[t].block}))
          sets.join(static_cast<int>(t), static_cast<int>(u));
    for (size_t head = 0; head < touches.size(); ++head) {
      if (sets.find(static_cast<int>(head)) != static_cast<int>(head)) continue;
      const int node = static_cast<int>(node_block_.size());
      node_block_.push_back({place[0], place[1], place[2], linked_object_[touches[head].block]});
      node_links_.push_back(kNone);
      for (size_t t = head; t < touches.size(); ++t) {
        if (sets.find(static_cast<int>(t)) != static_cast<int>(head)) continue;
        const auto [b, o] = touches[t];
        particle_links_[b][o] = node;
        std::array<int, 8>* links = &node_links_.back();
        for (size_t f = further_begin_.back(); (*links)[o] >= 0; ++f) {
          if (f == further_links_.size()) further_links_.push_back(kNone);
          links = &further_links_[f];
        }
        (*links)[o] = b;
      }
      further_begin_.push_back(static_cast<int>(further_links_.size()));
    }
  }
  sibling_.resize(node_block_.size());
  std::iota(sibling_.begin(), sibling_.end(), 0);
  if (further_links_.empty()) further_begin_.clear();
}

}  // namespace pliant
