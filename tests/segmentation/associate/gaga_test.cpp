// Association by Gaussians' centres, as in Gaga, on scenes with known truth.

#include "segmentation/associate/gaga.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "segmentation/associate/associate.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

/// The same masks with ids of each view's own.
MaskSet with_own_ids(MaskSet masks) {
  for (size_t v = 0; v < masks.views.size(); ++v)
    for (uint32_t& id : masks.views[v].ids.data)
      if (id != 0) id = static_cast<uint32_t>(1 + (id * 7919 + 104729 * v) % 100003);
  return masks;
}

/// Ids of `found` that pixels with a true id carry.
std::map<uint32_t, std::set<uint32_t>> found_ids(const MaskSet& truth, const MaskSet& found) {
  std::map<uint32_t, std::set<uint32_t>> out;
  for (size_t v = 0; v < found.views.size(); ++v)
    for (size_t i = 0; i < found.views[v].ids.data.size(); ++i)
      if (const uint32_t id = truth.views[v].ids.data[i]; id != 0) out[id].insert(found.views[v].ids.data[i]);
  return out;
}

TEST(Gaga, IdsOfOneViewEachBecomeIdsOfAllViews) {
  const MadeScene scene = made_scene(two_balls());
  const MaskSet truth = cast_masks(scene);
  const GagaResult result = associate_by_centres({}, scene.cloud, scene.cameras, with_own_ids(truth));
  EXPECT_EQ(result.summary.groups, 3);
  EXPECT_EQ(result.summary.views, 10);
  EXPECT_EQ(result.summary.masks, 30);
  std::set<uint32_t> all;
  for (const auto& [id, ids] : found_ids(truth, result.masks)) {
    EXPECT_EQ(ids.size(), 1u) << id;
    all.insert(*ids.begin());
  }
  EXPECT_EQ(all, (std::set<uint32_t>{1, 2, 3}));
}

// What the paper shows against trackers, which compare neighbouring views.
TEST(Gaga, AnObjectThatLeavesAndComesBackKeepsItsId) {
  const MadeScene scene = made_scene(two_balls(), 12);
  MaskSet truth = cast_masks(scene);
  for (int v = 4; v < 8; ++v)
    for (uint32_t& id : truth.views[v].ids.data)
      if (id == 70000) id = 0;
  const GagaResult result = associate_by_centres({}, scene.cloud, scene.cameras, with_own_ids(truth));
  EXPECT_EQ(result.summary.groups, 3);
  for (const auto& [id, ids] : found_ids(truth, result.masks)) EXPECT_EQ(ids.size(), 1u) << id;
}

// What comes first decides: two balls that the first view takes for one stay one, which ours cuts along its views.
TEST(Gaga, AMaskOfTwoObjectsInTheFirstViewJoinsThemInAllViews) {
  const MadeScene scene = made_scene(two_balls(), 12);
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  for (uint32_t& id : masks.views[0].ids.data)
    if (id == 70000) id = 300;
  masks = with_own_ids(masks);
  const GagaResult theirs = associate_by_centres({}, scene.cloud, scene.cameras, masks);
  const AssociateResult ours = associate({}, scene.cloud, scene.cameras, masks);
  const auto common = [&](const MaskSet& found) {
    auto ids = found_ids(truth, found);
    ids[300].erase(0);
    size_t n = 0;
    for (const uint32_t id : ids[300]) n += ids[70000].count(id);
    return n;
  };
  EXPECT_GT(common(theirs.masks), 0u);
  EXPECT_EQ(common(ours.masks), 0u);
}

TEST(Gaga, HeldOutViewsAreNeverLookedAtAndNamesStay) {
  const MadeScene scene = made_scene(two_balls());
  MaskSet masks = cast_masks(scene);
  masks.names = {{300, "red ball"}};
  GagaOptions options;
  options.held_out = {0, 5};
  const GagaResult expected = associate_by_centres(options, scene.cloud, scene.cameras, masks);
  ASSERT_EQ(expected.masks.views.size(), 8u);
  for (const MaskSet::View& view : expected.masks.views) EXPECT_TRUE(view.camera != 0 && view.camera != 5);
  ASSERT_EQ(expected.masks.names.size(), 1u);
  EXPECT_EQ(expected.masks.names.begin()->second, "red ball");
  for (const int held : options.held_out)
    std::fill(masks.views[held].ids.data.begin(), masks.views[held].ids.data.end(), 300u);
  const GagaResult found = associate_by_centres(options, scene.cloud, scene.cameras, masks);
  for (size_t v = 0; v < found.masks.views.size(); ++v)
    EXPECT_EQ(found.masks.views[v].ids.data, expected.masks.views[v].ids.data);
}

TEST(Gaga, MoreThan255ObjectsKeepTheirIds) {
  const MadeScene scene = made_scene(grid_of_balls(17), 4, 480, 360, 0.03f, 0.008f);
  const MaskSet truth = cast_masks(scene);
  const GagaResult result = associate_by_centres({}, scene.cloud, scene.cameras, with_own_ids(truth));
  EXPECT_GT(result.masks.ids().back(), 255u);
}

}  // namespace
}  // namespace pliant
