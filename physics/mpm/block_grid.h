#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "physics/mpm/block_table.h"

namespace pliant {

/// Which 4 x 4 x 4 blocks of cells hold particles, and which blocks of nodes their stencils touch.  A particle whose
/// lowest stencil node lies in block b touches nodes of b and of its seven upper neighbours only, so every block can
/// scatter into a 6 x 6 x 6 patch of its own, and every node block sums at most eight patches in a fixed order.
/// Objects share no blocks: where two touch, each has node blocks of its own at the same coordinates (`sibling`).
class BlockGrid {
 public:
  static constexpr int kSide = 4, kNodes = kSide * kSide * kSide;
  static constexpr int kPatch = kSide + 2, kPatchNodes = kPatch * kPatch * kPatch;
  static constexpr int kReach = 32000;  ///< coordinates lie between -kReach and kReach

  struct Coordinates {
    int x, y, z;
    int object = 0;  ///< below 2^15
    bool operator==(const Coordinates&) const = default;
  };
  /// Two particles that hang together.
  using Link = std::array<int, 2>;
  /// A particle that changes its block.
  struct Move {
    int place;  ///< in order()
    Coordinates to;
  };

  /// Sorts particles by block (stable) and links the blocks.
  void build(std::span<const Coordinates> block_of_particle);
  /// The same for a body whose particles hang together as `links` say: a block holds only what hangs together within
  /// it, and shares node blocks only with those that it hangs together with around them, so that parts that merely lie
  /// near each other have nodes of their own (virtual nodes; Molino, Bao and Fedkiw 2004).  Parts that reach no common
  /// node may share blocks of either kind all the same.  `corner` is the lowest node of each particle's stencil in its
  /// block, (4 i + j) 4 + k.  There is no `move` afterwards.
  void build_linked(std::span<const Coordinates> block_of_particle, std::span<const uint8_t> corner,
                    std::span<const Link> links);
  /// Takes particles to other blocks, where they follow those that stay; `moves` in ascending order of place.
  void move(std::span<const Move> moves);

  int particle_blocks() const { return static_cast<int>(block_.size()); }
  int node_blocks() const { return static_cast<int>(node_block_.size()); }

  /// Particles of particle block b: order()[begin(b)] .. order()[begin(b + 1)].
  int begin(int b) const { return begin_[b]; }
  const std::vector<int>& order() const { return order_; }
  std::vector<int>& order() { return order_; }  ///< particles of a block may be permuted
  const Coordinates& block(int b) const { return block_[b]; }
  int object_of(int b) const { return linked_ ? linked_object_[b] : block_[b].object; }
  /// Number of the particle block at `c`, or -1.
  int find(const Coordinates& c) const;
  const Coordinates& node_block(int n) const { return node_block_[n]; }
  /// Node block that holds nodes [4 o, 4 o + 4) of block b's patch, o = offset bits x * 4 + y * 2 + z.
  const std::array<int, 8>& nodes_of(int b) const { return particle_links_[b]; }
  /// Particle block whose patch reaches into node block n with offset o, or -1.
  const std::array<int, 8>& sources_of(int n) const { return node_links_[n]; }
  /// More of them, where several blocks of the same coordinates share it.
  std::span<const std::array<int, 8>> further_sources_of(int n) const {
    if (further_begin_.empty()) return {};
    return std::span(further_links_).subspan(further_begin_[n], further_begin_[n + 1] - further_begin_[n]);
  }

  /// The part of its block that a particle hangs together with; 0 where that hangs together with all around it.
  int part_of(int particle) const { return linked_ ? part_[particle] : 0; }
  /// Whether two parts that lie near each other hang together around some block of nodes.
  bool hang_together(int part, int other) const;

  /// Next node block at the same coordinates, of another object; in a ring, so n itself where there is no other.
  int sibling(int n) const { return sibling_[n]; }
  /// Node block of these coordinates, or -1.
  int find_node_block(const Coordinates& at) const;
  /// Whether any node block has a sibling.
  bool has_siblings() const { return has_siblings_; }
  /// Counts the changes; equal grids of one owner have equal versions.
  int64_t version() const { return version_; }
  /// Counts the changes of the set of blocks; their numbers stay valid while it stays the same.
  int64_t link_version() const { return link_version_; }
  /// Number of particle block b before the set of blocks last changed by `move`, or -1.
  int previous(int b) const { return previous_[b]; }

 private:
  void link(const std::vector<uint64_t>& sorted_keys);

  std::vector<int> begin_, order_, spare_order_;
  std::vector<Coordinates> block_, node_block_;
  std::vector<std::array<int, 8>> particle_links_, node_links_, further_links_;
  std::vector<int> further_begin_;  // [node blocks + 1], or empty
  std::vector<int> sibling_, previous_, linked_object_;
  std::vector<int> part_;                  // [particles]
  std::vector<std::array<int, 8>> hangs_;  // [1 + parts] the set around each node block that they hang with
  BlockTable block_table_, node_table_;
  bool has_siblings_ = false, linked_ = false;
  int64_t version_ = 0, link_version_ = 0;
};

/// Number of the node at place `at` of particle block b's patch.
inline size_t node_of_patch(const BlockGrid& grid, int b, int at) {
  constexpr int kSide = BlockGrid::kSide, kPatch = BlockGrid::kPatch;
  const int i = at / (kPatch * kPatch), j = at / kPatch % kPatch, k = at % kPatch;
  const int block = grid.nodes_of(b)[(i >= kSide) << 2 | (j >= kSide) << 1 | (k >= kSide)];
  return static_cast<size_t>(block) * BlockGrid::kNodes + ((i % kSide) * kSide + j % kSide) * kSide + k % kSide;
}

/// The nodes of particle block b's patch [6, 6, 6], out of its eight node blocks.
template <class N>
void collect_patch(const BlockGrid& grid, int b, const std::vector<N>& nodes, N* patch) {
  constexpr int kSide = BlockGrid::kSide, kPatch = BlockGrid::kPatch;
  for (int o = 0; o < 8; ++o) {
    const N* from = nodes.data() + static_cast<size_t>(grid.nodes_of(b)[o]) * BlockGrid::kNodes;
    const int ox = (o >> 2) * kSide, oy = (o >> 1 & 1) * kSide, oz = (o & 1) * kSide;
    const int ex = ox ? 2 : kSide, ey = oy ? 2 : kSide, ez = oz ? 2 : kSide;
    for (int i = 0; i < ex; ++i)
      for (int j = 0; j < ey; ++j)
        std::copy_n(from + (i * kSide + j) * kSide, ez, patch + ((i + ox) * kPatch + j + oy) * kPatch + oz);
  }
}

}  // namespace pliant
