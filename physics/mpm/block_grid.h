#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace pliant {

/// Which 4 x 4 x 4 blocks of cells hold particles, and which blocks of nodes their stencils touch.  A particle whose
/// lowest stencil node lies in block b touches nodes of b and of its seven upper neighbours only, so every block can
/// scatter into a 6 x 6 x 6 patch of its own, and every node block sums at most eight patches in a fixed order.
class BlockGrid {
 public:
  static constexpr int kSide = 4, kNodes = kSide * kSide * kSide;
  static constexpr int kPatch = kSide + 2, kPatchNodes = kPatch * kPatch * kPatch;

  struct Coordinates {
    int x, y, z;
    bool operator==(const Coordinates&) const = default;
  };

  /// Sorts particles by block (stable) and links the blocks.  `low`, `high` bound the coordinates.
  void build(const std::vector<Coordinates>& block_of_particle, const Coordinates& low, const Coordinates& high);

  /// Number of calls of `build`; equal grids of one owner have equal versions.
  int version() const { return version_; }

  int particle_blocks() const { return static_cast<int>(particle_links_.size()); }
  int node_blocks() const { return static_cast<int>(node_links_.size()); }

  /// Particles of particle block b: order()[begin(b)] .. order()[begin(b + 1)].
  int begin(int b) const { return begin_[b]; }
  const std::vector<int>& order() const { return order_; }
  const Coordinates& node_block(int n) const { return node_block_[n]; }
  /// Node block that holds nodes [4 o, 4 o + 4) of block b's patch, o = offset bits x * 4 + y * 2 + z.
  const std::array<int, 8>& nodes_of(int b) const { return particle_links_[b]; }
  /// Particle block whose patch reaches into node block n with offset o, or -1.
  const std::array<int, 8>& sources_of(int n) const { return node_links_[n]; }

 private:
  int version_ = 0;
  std::vector<int> begin_, order_, key_, table_, node_table_;
  std::vector<Coordinates> node_block_;
  std::vector<std::array<int, 8>> particle_links_, node_links_;
};

}  // namespace pliant
