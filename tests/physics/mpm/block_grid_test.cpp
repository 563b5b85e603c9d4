#include "physics/mpm/block_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

using Coordinates = BlockGrid::Coordinates;
using Key = std::tuple<int, int, int, int>;

Key key(const Coordinates& c) { return {c.object, c.x, c.y, c.z}; }

std::vector<Coordinates> random_blocks(int n, int objects, uint64_t seed) {
  std::vector<Coordinates> block(n);
  for (int i = 0; i < n; ++i) {
    Random random(seed, i);
    const auto along = [&] { return static_cast<int>(random.uniform(-3, 3)); };
    block[i] = {along(), along(), along(), static_cast<int>(random.uniform(0, objects))};
  }
  return block;
}

/// Every particle lies in its block, blocks are sorted, and links lead there and back.
void expect_consistent(const BlockGrid& grid, const std::vector<Coordinates>& block_of) {
  std::set<int> seen;
  for (int b = 0; b < grid.particle_blocks(); ++b) {
    ASSERT_LT(grid.begin(b), grid.begin(b + 1));
    if (b > 0) {
      ASSERT_LT(key(grid.block(b - 1)), key(grid.block(b)));
    }
    for (int s = grid.begin(b); s < grid.begin(b + 1); ++s) {
      ASSERT_EQ(block_of[grid.order()[s]], grid.block(b));
      seen.insert(grid.order()[s]);
    }
    for (int o = 0; o < 8; ++o) {
      const int n = grid.nodes_of(b)[o];
      Coordinates expected = grid.block(b);
      expected.x += o >> 2;
      expected.y += o >> 1 & 1;
      expected.z += o & 1;
      ASSERT_EQ(grid.node_block(n), expected);
      ASSERT_EQ(grid.sources_of(n)[o], b);
    }
  }
  ASSERT_EQ(seen.size(), block_of.size());
}

TEST(BlockGrid, BlocksHoldTheirParticlesAndLinksLeadThereAndBack) {
  const auto block_of = random_blocks(2000, 3, 1);
  BlockGrid grid;
  grid.build(block_of);
  expect_consistent(grid, block_of);
}

// Two rows of blocks, one above the other, a particle to a block in each; in the first and the last block a link leads
// from one row to the other, or in none.
TEST(BlockGrid, BlocksShareNodesOnlyWithWhatTheyHangTogetherWithAroundThem) {
  constexpr int kBlocks = 6;
  std::vector<Coordinates> block_of;
  for (int row = 0; row < 2; ++row)
    for (int x = 0; x < kBlocks; ++x) block_of.push_back({x, 0, 0});
  std::vector<BlockGrid::Link> links;
  for (int row = 0; row < 2; ++row)
    for (int x = 0; x + 1 < kBlocks; ++x) links.push_back({kBlocks * row + x, kBlocks * row + x + 1});
  const auto shared_at = [&](const BlockGrid& grid) {
    // Whether the rows share the first node block of the blocks at x.
    std::vector<bool> shared;
    for (int x = 0; x < kBlocks; ++x) shared.push_back(grid.nodes_of(x)[0] == grid.nodes_of(kBlocks + x)[0]);
    return shared;
  };
  const std::vector<uint8_t> corner(block_of.size(), 63);  // the last one: all eight node blocks are reached
  BlockGrid apart;
  apart.build_linked(block_of, corner, links);
  ASSERT_EQ(apart.particle_blocks(), 2 * kBlocks);
  EXPECT_EQ(apart.node_blocks(), 2 * (kBlocks + 1) * 4);
  EXPECT_EQ(shared_at(apart), std::vector<bool>(kBlocks, false));

  links.push_back({0, kBlocks});  // within one block, so that it is not split
  BlockGrid joined;
  joined.build_linked(block_of, corner, links);
  ASSERT_EQ(joined.particle_blocks(), 2 * kBlocks - 1);
  // Both second blocks hang together with it around their common nodes, and share those; the third ones do not.
  EXPECT_EQ(joined.node_blocks(), 2 * (kBlocks + 1) * 4 - 8);
  EXPECT_EQ(joined.nodes_of(1)[0], joined.nodes_of(kBlocks)[0]);
  EXPECT_NE(joined.nodes_of(2)[0], joined.nodes_of(kBlocks + 1)[0]);

  // Every block is a source of each of its node blocks, once.
  for (const BlockGrid* grid : {&apart, &joined})
    for (int b = 0; b < grid->particle_blocks(); ++b)
      for (int o = 0; o < 8; ++o) {
        const int n = grid->nodes_of(b)[o];
        int found = grid->sources_of(n)[o] == b;
        for (const auto& more : grid->further_sources_of(n)) found += more[o] == b;
        EXPECT_EQ(found, 1);
      }
}

TEST(BlockGrid, PartsThatReachNoCommonNodeShareBlocksAndYetDoNotHangTogether) {
  // Three particles of one block without links between them: the first two reach the nodes 0 .. 2 along x, the last one
  // 3 .. 5.
  const std::vector<Coordinates> block_of(3, {0, 0, 0});
  const std::vector<uint8_t> corner = {0, 0, 48};
  const std::vector<BlockGrid::Link> links = {{0, 0}};  // some, which join nothing
  BlockGrid grid;
  grid.build_linked(block_of, corner, links);
  EXPECT_EQ(grid.particle_blocks(), 2);
  EXPECT_EQ(grid.node_blocks(), 8 + 1) << "one more where the first two meet";
  const auto block = [&](int particle) {
    for (int b = 0; b < grid.particle_blocks(); ++b)
      for (int s = grid.begin(b); s < grid.begin(b + 1); ++s)
        if (grid.order()[s] == particle) return b;
    return -1;
  };
  EXPECT_EQ(block(0), block(2));
  EXPECT_NE(grid.nodes_of(block(0))[0], grid.nodes_of(block(1))[0]);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(grid.hang_together(grid.part_of(i), grid.part_of(k)), i == k);
}

TEST(BlockGrid, ObjectsShareNoBlockHoweverTheyAreLinked) {
  // Two objects of two linked particles each, in one block.
  const std::vector<Coordinates> block_of = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 1}, {0, 0, 0, 1}};
  const std::vector<uint8_t> corner(4, 63);
  const std::vector<BlockGrid::Link> links = {{0, 1}, {2, 3}};
  BlockGrid grid;
  grid.build_linked(block_of, corner, links);
  ASSERT_EQ(grid.particle_blocks(), 2);
  EXPECT_EQ(grid.node_blocks(), 16);
  for (int b = 0; b < 2; ++b) {
    EXPECT_EQ(grid.begin(b + 1) - grid.begin(b), 2);
    EXPECT_EQ(block_of[grid.order()[grid.begin(b)]].object, block_of[grid.order()[grid.begin(b + 1) - 1]].object);
  }
}

TEST(BlockGrid, MovedParticlesLieWhereANewSortPutsThem) {
  auto block_of = random_blocks(500, 2, 2);
  BlockGrid grid;
  grid.build(block_of);
  for (int round = 0; round < 30; ++round) {
    // Few moves keep the set of blocks, many change it.
    std::vector<BlockGrid::Move> moves;
    const double part = round % 3 == 0 ? 0.002 : 0.2;
    for (int s = 0; s < 500; ++s) {
      Random random(3 + round, s);
      if (random.uniform() > part) continue;
      Coordinates to = block_of[grid.order()[s]];
      to.x += random.uniform() < 0.5 ? 1 : -1;
      moves.push_back({s, to});
    }
    for (const auto& m : moves) block_of[grid.order()[m.place]] = m.to;
    grid.move(moves);
    expect_consistent(grid, block_of);
  }
}

TEST(BlockGrid, SiblingsAreTheNodeBlocksOfAllObjectsAtTheSamePlace) {
  BlockGrid grid;
  grid.build(random_blocks(400, 4, 5));
  EXPECT_TRUE(grid.has_siblings());
  std::map<std::tuple<int, int, int>, std::set<int>> at;
  for (int n = 0; n < grid.node_blocks(); ++n) {
    const Coordinates& c = grid.node_block(n);
    at[{c.x, c.y, c.z}].insert(n);
  }
  for (int n = 0; n < grid.node_blocks(); ++n) {
    const Coordinates& c = grid.node_block(n);
    std::set<int> ring = {n};
    for (int k = grid.sibling(n); k != n; k = grid.sibling(k)) ASSERT_TRUE(ring.insert(k).second);
    EXPECT_EQ(ring, (at[{c.x, c.y, c.z}]));
  }
  grid.build(random_blocks(400, 1, 5));
  EXPECT_FALSE(grid.has_siblings());
}

}  // namespace
}  // namespace pliant
