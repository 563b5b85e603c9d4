// Nodes of a body whose parts lie near each other without hanging together.

#include <map>
#include <numeric>

#include "gaussians/base/disjoint_sets.h"
#include "physics/mpm/block_grid.h"

namespace pliant {
namespace {

constexpr int kSide = BlockGrid::kSide;
using Place = std::array<int, 3>;
/// The nodes that stencils reach in each of the eight node blocks of a particle block, a bit each.
using Reach = std::array<uint64_t, 8>;

Place place_of(const BlockGrid::Coordinates& c, int offset) {
  return {c.x + (offset >> 2), c.y + (offset >> 1 & 1), c.z + (offset & 1)};
}

void add_stencil(int corner, Reach& reach) {
  for (int k = 0; k < 27; ++k) {
    const int x = corner / (kSide * kSide) + k / 9, y = corner / kSide % kSide + k / 3 % 3, z = corner % kSide + k % 3;
    const int node = ((x % kSide) * kSide + y % kSide) * kSide + z % kSide;
    reach[(x >= kSide) << 2 | (y >= kSide) << 1 | (z >= kSide)] |= uint64_t{1} << node;
  }
}

/// Particles of one block that hang together within it.
struct Part {
  BlockGrid::Coordinates block;
  Reach reach{};
  std::array<int, 8> touch{};  ///< its place in the list of each of its node blocks
};

/// Parts by the number of the particle; `part` gets it for each.
std::vector<Part> parts_of(std::span<const BlockGrid::Coordinates> block_of_particle, std::span<const uint8_t> corner,
                           std::span<const BlockGrid::Link> links, std::vector<int>& part) {
  const size_t n = block_of_particle.size();
  DisjointSets hang(n);
  for (const auto& [i, k] : links)
    if (block_of_particle[i] == block_of_particle[k]) hang.join(i, k);
  std::vector<Part> parts;
  part.resize(n);
  for (size_t i = 0; i < n; ++i) {
    const int first = hang.find(static_cast<int>(i));
    if (first == static_cast<int>(i)) {
      part[i] = static_cast<int>(parts.size());
      parts.push_back({block_of_particle[i]});
    } else {
      part[i] = part[first];
    }
    add_stencil(corner[i], parts[part[i]].reach);
  }
  return parts;
}

/// Pairs of parts that a link joins, (smaller, larger), in order.
std::vector<std::array<int, 2>> joined_parts(std::span<const BlockGrid::Link> links, const std::vector<int>& part) {
  std::vector<std::array<int, 2>> joined;
  for (const auto& [i, k] : links)
    if (part[i] != part[k]) joined.push_back({std::min(part[i], part[k]), std::max(part[i], part[k])});
  std::sort(joined.begin(), joined.end());
  joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
  return joined;
}

/// The parts that reach a node block, in sets that share their nodes.
class Sharing {
 public:
  int add(int part, int offset, uint64_t reached) {
    touches_.push_back({part, offset, reached});
    return sets_.add();
  }
  int size() const { return static_cast<int>(touches_.size()); }
  int part(int t) const { return touches_[t].part; }
  int offset(int t) const { return touches_[t].offset; }
  int head(int t) { return sets_.find(t); }
  void join(int t, int u) {
    const uint64_t reached = touches_[head(t)].reached | touches_[head(u)].reached;
    sets_.join(t, u);
    touches_[head(t)].reached = reached;
  }
  /// Whether nothing changes when they share their nodes.
  bool may_join(int t, int u) {
    return head(t) == head(u) || (touches_[head(t)].reached & touches_[head(u)].reached) == 0;
  }

 private:
  struct Touch {
    int part, offset;
    uint64_t reached;  // by its set, at the head
  };
  std::vector<Touch> touches_;
  DisjointSets sets_;
};

/// What hangs together around a node block shares its nodes.
std::map<Place, Sharing> share_nodes(std::vector<Part>& parts, const std::vector<std::array<int, 2>>& joined) {
  std::map<Place, Sharing> around;
  for (size_t p = 0; p < parts.size(); ++p)
    for (int o = 0; o < 8; ++o)
      parts[p].touch[o] = around[place_of(parts[p].block, o)].add(static_cast<int>(p), o, parts[p].reach[o]);
  for (auto& [place, sharing] : around)
    for (int t = 0; t < sharing.size(); ++t)
      for (int u = 0; u < t; ++u) {
        const std::array<int, 2> pair = {std::min(sharing.part(u), sharing.part(t)),
                                         std::max(sharing.part(u), sharing.part(t))};
        if (std::binary_search(joined.begin(), joined.end(), pair)) sharing.join(t, u);
      }
  return around;
}

/// Parts of a block that reach no common node share it: which one of the block's [parts] each of them is in.
std::vector<int> share_blocks(const std::vector<Part>& parts, std::map<Place, Sharing>& around) {
  std::vector<int> number(parts.size());
  std::map<Place, std::vector<int>> firsts;  // of each block of any object, the first part in it
  for (size_t p = 0; p < parts.size(); ++p) {
    const Part& part = parts[p];
    std::vector<int>& of_place = firsts[{part.block.x, part.block.y, part.block.z}];
    size_t k = 0;
    for (; k < of_place.size(); ++k) {
      bool fits = parts[of_place[k]].block.object == part.block.object;
      for (int o = 0; o < 8 && fits; ++o)
        fits = around.at(place_of(part.block, o)).may_join(part.touch[o], parts[of_place[k]].touch[o]);
      if (fits) break;
    }
    number[p] = static_cast<int>(k);
    if (k == of_place.size()) {
      of_place.push_back(static_cast<int>(p));
    } else {
      for (int o = 0; o < 8; ++o) around.at(place_of(part.block, o)).join(part.touch[o], parts[of_place[k]].touch[o]);
    }
  }
  return number;
}

}  // namespace

void BlockGrid::build_linked(std::span<const Coordinates> block_of_particle, std::span<const uint8_t> corner,
                             std::span<const Link> links) {
  const size_t n = block_of_particle.size();
  std::vector<Part> parts = parts_of(block_of_particle, corner, links, part_);
  std::map<Place, Sharing> around = share_nodes(parts, joined_parts(links, part_));

  hangs_.assign(parts.size(), {});
  std::vector<uint8_t> whole(parts.size(), 1);  // the only set around each of their node blocks is theirs
  int sets = 0;
  for (auto& [place, sharing] : around) {
    bool one = true;
    for (int t = 0; t < sharing.size(); ++t) {
      hangs_[sharing.part(t)][sharing.offset(t)] = sets + sharing.head(t);
      one &= sharing.head(t) == 0;
    }
    for (int t = 0; t < sharing.size(); ++t) whole[sharing.part(t)] &= one;
    sets += sharing.size();
  }

  const std::vector<int> number = share_blocks(parts, around);
  std::vector<Coordinates> block(n);
  for (size_t i = 0; i < n; ++i) {
    block[i] = block_of_particle[i];
    block[i].object = number[part_[i]];
  }
  build(block);
  linked_ = true;
  // The objects, whose place the numbers of the parts took.
  linked_object_.resize(particle_blocks());
  std::vector<int> block_of_part(parts.size());
  for (int b = 0; b < particle_blocks(); ++b) {
    linked_object_[b] = block_of_particle[order_[begin_[b]]].object;
    for (int s = begin_[b]; s < begin_[b + 1]; ++s) block_of_part[part_[order_[s]]] = b;
  }

  hangs_.insert(hangs_.begin(), {{}});
  for (int& part : part_) part = whole[part] ? 0 : part + 1;

  node_block_.clear();
  node_links_.clear();
  further_links_.clear();
  further_begin_.assign(1, 0);
  node_table_.clear(1);
  has_siblings_ = false;
  constexpr std::array<int, 8> kNone = {-1, -1, -1, -1, -1, -1, -1, -1};
  for (auto& [place, sharing] : around) {
    const auto object = [&, &sharing = sharing](int t) { return linked_object_[block_of_part[sharing.part(t)]]; };
    // Sets that reach no common node share a node block too.
    for (int t = 0; t < sharing.size(); ++t)
      for (int u = 0; u < t && sharing.head(t) == t; ++u)
        if (sharing.head(u) == u && object(u) == object(t) && sharing.may_join(u, t)) sharing.join(u, t);
    for (int head = 0; head < sharing.size(); ++head) {
      if (sharing.head(head) != head) continue;
      const int node = static_cast<int>(node_block_.size());
      node_block_.push_back({place[0], place[1], place[2], object(head)});
      node_links_.push_back(kNone);
      for (int t = head; t < sharing.size(); ++t) {
        if (sharing.head(t) != head) continue;
        const int b = block_of_part[sharing.part(t)], o = sharing.offset(t);
        particle_links_[b][o] = node;
        std::array<int, 8>* links_of = &node_links_.back();
        for (size_t f = further_begin_.back(); (*links_of)[o] >= 0 && (*links_of)[o] != b; ++f) {
          if (f == further_links_.size()) further_links_.push_back(kNone);
          links_of = &further_links_[f];
        }
        (*links_of)[o] = b;
      }
      further_begin_.push_back(static_cast<int>(further_links_.size()));
    }
  }
  sibling_.resize(node_block_.size());
  std::iota(sibling_.begin(), sibling_.end(), 0);
  if (further_links_.empty()) further_begin_.clear();
}

bool BlockGrid::hang_together(int a, int b) const {
  if (a == 0 || b == 0) return true;
  for (const int n : hangs_[a])
    for (const int m : hangs_[b])
      if (n == m) return true;
  return false;
}

}  // namespace pliant
