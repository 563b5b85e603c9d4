// Association of masks whose ids hold only inside their own view, on scenes with known truth.

#include "segmentation/associate/associate.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <map>
#include <set>

#include "gaussians/io/images/image_io.h"
#include "segmentation/associate/gaga.h"
#include "segmentation/field/semantic_field.h"
#include "segmentation/labels/agreement.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

/// Ids drawn anew in every view.
MaskSet shuffled(MaskSet masks, uint64_t seed = 1) {
  for (MaskSet::View& view : masks.views) {
    std::map<uint32_t, uint32_t> fresh;
    std::set<uint32_t> taken{0};
    for (uint32_t& id : view.ids.data) {
      if (id == 0) continue;
      Random random(seed, view.camera, fresh.size());
      uint32_t& own = fresh[id];
      while (own == 0 || (taken.count(own) && fresh.size() != taken.size() - 1))
        own = 1 + static_cast<uint32_t>(random.below(60000));
      taken.insert(own);
      id = own;
    }
  }
  return masks;
}

void replace(IdImage& ids, uint32_t from, uint32_t to) { std::replace(ids.data.begin(), ids.data.end(), from, to); }

/// Labelled pixels of `masks` that do not carry the true id, after ids are matched by overlap.
struct Errors {
  size_t wrong = 0, empty = 0, pixels = 0;
};
Errors errors_of(const MaskSet& masks, const MaskSet& truth) {
  OverlapMatch overlaps;
  std::map<int, const IdImage*> by_camera;
  for (const MaskSet::View& view : truth.views) by_camera[view.camera] = &view.ids;
  for (const MaskSet::View& view : masks.views) overlaps.add(view.ids.data, by_camera.at(view.camera)->data);
  const auto match = overlaps.match();
  Errors errors;
  for (const MaskSet::View& view : masks.views) {
    const IdImage& own = *by_camera.at(view.camera);
    for (size_t i = 0; i < own.data.size(); ++i) {
      if (own.data[i] == 0) continue;
      ++errors.pixels;
      const uint32_t id = view.ids.data[i];
      if (id == 0)
        ++errors.empty;
      else
        errors.wrong += !match.count(id) || match.at(id) != own.data[i];
    }
  }
  return errors;
}

std::vector<MadeScene::Ball> three_balls() {
  auto balls = two_balls();
  balls.push_back({Vec3f(0.15f, 0.55f, 0.13f), 0.2f, 7, Vec3f(0.2f, 0.7f, 0.2f)});
  return balls;
}

TEST(Associate, ConsistentIdsComeBackAsTheyAre) {
  const MadeScene scene = made_scene(three_balls());
  MaskSet masks = cast_masks(scene);
  masks.names = {{300, "red ball"}};
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, masks);
  ASSERT_EQ(result.masks.views.size(), masks.views.size());
  for (size_t v = 0; v < masks.views.size(); ++v)
    EXPECT_EQ(result.masks.views[v].ids.data, masks.views[v].ids.data) << v;
  EXPECT_EQ(result.masks.names, masks.names);
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_EQ(result.summary.kept_ids, 4);
  EXPECT_EQ(result.summary.reused_ids, 0);
  EXPECT_EQ(result.summary.merged + result.summary.split + result.summary.ignored, 0);
  EXPECT_GT(result.summary.consistency, 0.95);
}

/// Masks of three_balls() in which only the table has one id in all views.
MaskSet turning_masks(const MadeScene& scene, uint32_t table) {
  MaskSet masks = cast_masks(scene);
  for (size_t v = 0; v < masks.views.size(); ++v) {
    const auto turned = [&](size_t k) { return static_cast<uint32_t>(2 + (k + v) % 3); };
    const std::map<uint32_t, uint32_t> ids = {
        {0, 0}, {MadeScene::kTable, table}, {300, turned(0)}, {70000, turned(1)}, {7, turned(2)}};
    for (uint32_t& id : masks.views[v].ids.data) id = ids.at(id);
  }
  return masks;
}

TEST(Associate, NewIdsFitIntoAPicture) {
  const MadeScene scene = made_scene(three_balls(), 9);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, turning_masks(scene, kLargestId));
  EXPECT_EQ(result.masks.ids(), (std::vector<uint32_t>{1, 2, 3, kLargestId}));
}

// Numbers that new groups are given may be ids that no group kept, whose names they do not get.
TEST(Associate, OnlyIdsThatAreKeptHaveNames) {
  const MadeScene scene = made_scene(three_balls(), 9);
  MaskSet masks = turning_masks(scene, 1);
  masks.names = {{1, "table"}, {2, "a"}, {3, "b"}, {4, "c"}};
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, masks);
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_EQ(result.summary.kept_ids, 1);
  EXPECT_EQ(result.summary.reused_ids, 3);
  EXPECT_EQ(result.masks.ids(), (std::vector<uint32_t>{1, 2, 3, 4}));
  EXPECT_EQ(result.masks.names, (std::map<uint32_t, std::string>{{1, "table"}}));
  for (const auto& [group, name] : associate_by_centres({}, scene.cloud, scene.cameras, masks).masks.names)
    EXPECT_EQ(name, "table") << group;
}

TEST(Associate, IdsOfOneViewEachBecomeIdsOfAllViews) {
  const MadeScene scene = made_scene(three_balls());
  const MaskSet truth = cast_masks(scene);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(truth));
  EXPECT_EQ(result.masks.ids(), (std::vector<uint32_t>{1, 2, 3, 4}));
  const Errors errors = errors_of(result.masks, truth);
  EXPECT_EQ(errors.wrong + errors.empty, 0u);
  EXPECT_LT(result.summary.consistency, 0.2);
  EXPECT_GT(result.summary.overlap, 0.8);
}

TEST(Associate, DoesNotDependOnTheOrderOfViewsNorOnTheIdsInsideThem) {
  const MadeScene scene = made_scene(three_balls());
  MaskSet masks = cast_masks(scene);
  replace(masks.views[2].ids, 300, MadeScene::kTable);
  replace(masks.views[4].ids, 7, 0);
  const AssociateResult expected = associate({}, scene.cloud, scene.cameras, shuffled(masks, 1));
  for (uint64_t seed : {2, 3}) {
    MaskSet other = shuffled(masks, seed);
    Random random(seed);
    for (size_t i = other.views.size(); i > 1; --i) std::swap(other.views[i - 1], other.views[random.below(i)]);
    const AssociateResult found = associate({}, scene.cloud, scene.cameras, other);
    ASSERT_EQ(found.masks.views.size(), expected.masks.views.size());
    for (const MaskSet::View& view : found.masks.views)
      EXPECT_EQ(view.ids.data, expected.masks.views[view.camera].ids.data);
  }
}

TEST(Associate, TheSameObjectsAreFoundWhenTheCamerasHaveOtherNames) {
  MadeScene scene = made_scene(three_balls());
  MaskSet masks = shuffled(cast_masks(scene));
  replace(masks.views[3].ids, masks.views[3].ids(60, 45), 0);
  const AssociateResult expected = associate({}, scene.cloud, scene.cameras, masks);
  for (size_t c = 0; c < scene.cameras.size(); ++c) scene.cameras[c].name = std::to_string((7 * c + 3) % 10);
  const AssociateResult found = associate({}, scene.cloud, scene.cameras, masks);
  const Errors errors = errors_of(found.masks, expected.masks);
  EXPECT_EQ(errors.wrong + errors.empty, 0u);
  EXPECT_EQ(found.masks.ids().size(), expected.masks.ids().size());
}

TEST(Associate, AnObjectThatLeavesAndComesBackKeepsItsId) {
  const MadeScene scene = made_scene(three_balls(), 12);
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  for (int v = 4; v < 8; ++v) replace(masks.views[v].ids, 70000, 0);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(masks));
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_EQ(errors_of(result.masks, masks).wrong, 0u);
  for (int v = 4; v < 8; ++v)  // what is not labelled stays so
    for (size_t i = 0; i < masks.views[v].ids.data.size(); ++i)
      EXPECT_EQ(result.masks.views[v].ids.data[i] == 0, masks.views[v].ids.data[i] == 0);
}

TEST(Associate, AMaskOfTwoObjectsIsCutAlongThem) {
  const MadeScene scene = made_scene(three_balls(), 12);
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  replace(masks.views[1].ids, 300, 70000);            // two balls
  replace(masks.views[5].ids, 7, MadeScene::kTable);  // a ball and the table under it
  replace(masks.views[9].ids, 300, MadeScene::kTable);
  replace(masks.views[9].ids, 70000, MadeScene::kTable);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(masks));
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_EQ(result.summary.merged, 3);
  const Errors errors = errors_of(result.masks, truth);
  EXPECT_LT(errors.wrong, 0.003 * errors.pixels);
  EXPECT_LT(errors.empty, 0.01 * errors.pixels);
}

TEST(Associate, SeveralMasksOfOneObjectGetOneId) {
  const MadeScene scene = made_scene(three_balls(), 12);
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  for (int v : {2, 7})  // halves of the first ball, and of the table
    for (int y = 0; y < masks.views[v].ids.height; ++y)
      for (int x = 0; x < 60; ++x)
        for (uint32_t id : {300u, MadeScene::kTable})
          if (masks.views[v].ids(x, y) == id) masks.views[v].ids(x, y) = id + 1000000;
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(masks));
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_GE(result.summary.split, 4);
  const Errors errors = errors_of(result.masks, truth);
  EXPECT_EQ(errors.wrong + errors.empty, 0u);
}

TEST(Associate, MissingMasksAreNoEvidence) {
  const MadeScene scene = made_scene(three_balls(), 12);
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  for (MaskSet::View& view : masks.views)
    for (uint32_t id : {3u, 300u, 70000u, 7u})
      if (Random(3, view.camera, id).uniform() < 0.4) replace(view.ids, id, 0);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(masks));
  EXPECT_EQ(result.summary.groups, 4);
  EXPECT_EQ(errors_of(result.masks, masks).wrong, 0u);
}

TEST(Associate, IdsThatAgreeBetweenViewsAreKeptOnRequest) {
  const MadeScene scene = made_scene(three_balls());
  const MaskSet truth = cast_masks(scene);
  AssociateOptions options;
  options.keep_above = 0.75;
  const AssociateResult kept = associate(options, scene.cloud, scene.cameras, truth);
  EXPECT_FALSE(kept.summary.associated);
  EXPECT_EQ(kept.masks.views[3].ids.data, truth.views[3].ids.data);
  EXPECT_TRUE(associate(options, scene.cloud, scene.cameras, shuffled(truth)).summary.associated);
}

TEST(Associate, ATrackThatLosesItsIdGetsItBack) {
  const MadeScene scene = made_scene(three_balls());
  const MaskSet truth = cast_masks(scene);
  MaskSet masks = truth;
  for (int v = 6; v < 10; ++v) replace(masks.views[v].ids, 300, 5000);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, masks);
  for (size_t v = 0; v < truth.views.size(); ++v)
    EXPECT_EQ(result.masks.views[v].ids.data, truth.views[v].ids.data) << v;
}

TEST(Associate, HeldOutMasksAreNeverLookedAt) {
  const MadeScene scene = made_scene(three_balls());
  const MaskSet masks = shuffled(cast_masks(scene));
  MaskSet wrong = masks;
  for (uint32_t& id : wrong.views[5].ids.data) id = 999;
  AssociateOptions options;
  options.held_out = {5};
  const AssociateResult a = associate(options, scene.cloud, scene.cameras, masks),
                        b = associate(options, scene.cloud, scene.cameras, wrong);
  ASSERT_EQ(a.masks.views.size(), 9u);
  for (size_t v = 0; v < 9; ++v) EXPECT_EQ(a.masks.views[v].ids.data, b.masks.views[v].ids.data);
}

TEST(Associate, EqualBitForBitForAnyNumberOfThreads) {
  const MadeScene scene = made_scene(three_balls());
  MaskSet masks = cast_masks(scene);
  replace(masks.views[1].ids, 300, 70000);
  masks = shuffled(masks);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const AssociateResult one = associate({}, scene.cloud, scene.cameras, masks);
  for (int n : {2, 3}) {
    omp_set_num_threads(n);
    const AssociateResult many = associate({}, scene.cloud, scene.cameras, masks);
    for (size_t v = 0; v < masks.views.size(); ++v)
      EXPECT_EQ(one.masks.views[v].ids.data, many.masks.views[v].ids.data);
    EXPECT_EQ(one.summary.overlap, many.summary.overlap);
  }
  omp_set_num_threads(threads);
}

TEST(Associate, FourHundredObjectsAndMoreIdsThanEightBitsHold) {
  std::vector<MadeScene::Ball> balls;
  for (int i = 0; i < 20; ++i)
    for (int j = 0; j < 20; ++j)
      balls.push_back({Vec3f(-0.9f + 1.8f * i / 19, -0.9f + 1.8f * j / 19, 0.035f), 0.045f,
                       static_cast<uint32_t>(1000 + 20 * i + j), Vec3f::Zero()});
  MadeScene scene = made_scene(balls, 0);
  scene.cloud = {};
  scene.truth.clear();
  for (float x = -1; x <= 1; x += 0.02f)
    for (float y = -1; y <= 1; y += 0.02f) add_disc(scene.cloud, Vec3f(x, y, 0), Vec3f::UnitZ(), 0.012f, Vec3f::Ones());
  for (const auto& ball : balls)
    for (int i = 0; i < 60; ++i) {
      const float z = 1 - (i + 0.5f) / 40, r = std::sqrt(std::max(0.0f, 1 - z * z)), angle = 2.399963f * i;
      const Vec3f normal(r * std::cos(angle), r * std::sin(angle), z);
      add_disc(scene.cloud, ball.centre + 0.036f * normal, normal, 0.008f, ball.colour);
    }
  for (int v = 0; v < 6; ++v) {
    const double angle = 2 * M_PI * v / 6;
    scene.cameras.push_back(
        look_at({1.5 * std::cos(angle), 1.5 * std::sin(angle), 2.2}, {0, 0, 0}, {0, 0, 1}, 330, 280, 385));
    scene.cameras.back().name = "view" + std::to_string(v);
  }
  const MaskSet truth = cast_masks(scene);
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, shuffled(truth));
  EXPECT_NEAR(result.summary.groups, 401, 4);
  const Errors errors = errors_of(result.masks, truth);
  EXPECT_LT(errors.wrong + errors.empty, 0.01 * errors.pixels);
}

TEST(Associate, MaskOfTheEmptySpaceAroundAThingStandsOnNothing) {
  MadeScene scene = made_scene(two_balls(), 8);
  std::vector<int> balls;
  for (size_t p = 0; p < scene.cloud.size(); ++p)
    if (scene.truth[p] != MadeScene::kTable) balls.push_back(static_cast<int>(p));
  scene.cloud = scene.cloud.select(balls);
  MaskSet masks = cast_masks(scene);
  for (MaskSet::View& view : masks.views)
    for (uint32_t& id : view.ids.data) id = id == 0 || id == MadeScene::kTable ? 2 : 1;
  AssociateOptions options;
  options.keep_above = 0.75;
  const AssociateResult result = associate(options, scene.cloud, scene.cameras, masks);
  EXPECT_FALSE(result.summary.associated) << result.summary.describe();
  EXPECT_EQ(result.masks.views[3].ids.data, masks.views[3].ids.data);
}

TEST(ContourBands, AreTheMasksWithoutTheirErosion) {
  IdImage ids(9, 9, 1);
  for (int y = 1; y < 8; ++y)
    for (int x = 0; x < 7; ++x) ids(x, y) = 5;  // 7 x 7, at the left border of the picture
  for (int band : {1, 2, 3}) {
    std::vector<uint8_t> ring = contour_bands(ids, band);
    EXPECT_EQ(ring[8 * 9 + 4], 1);  // of what is below the square
    for (size_t i = 0; i < ring.size(); ++i) ring[i] = ring[i] && ids.data[i] == 5;
    const int inner = 7 - 2 * band;
    EXPECT_EQ(std::count(ring.begin(), ring.end(), 1), 49 - inner * inner);
    EXPECT_EQ(ring[4 * 9 + 3], 0);
    EXPECT_EQ(ring[4 * 9], 1);
  }
}

TEST(CountBoundaries, AreTheOverlapsOfTheBandsOfEachIdByItself) {
  IdImage truth(60, 50, 1), ours(60, 50, 1);
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 60; ++x) {
      truth(x, y) = x < 5 ? 0 : 1 + (x / 13 + y / 11) % 4;
      ours(x, y) = 1 + ((x + y / 9) / 13 + y / 12) % 5;  // one id more than the truth has
    }
  for (int band : {1, 3}) {
    std::map<uint32_t, OverlapCount> overlap;
    count_boundaries(ours, truth, band, overlap);
    ASSERT_EQ(overlap.size(), 5u);
    EXPECT_EQ(boundary_agreement({&ours, 1}, {&truth, 1}, band).iou.size(), 4u);
    for (const auto& [id, count] : overlap) {
      // Each id alone: the ring of its mask, by looking at every pixel around.
      const auto ring = [&](const IdImage& ids, int x, int y) {
        if (ids(x, y) != id) return false;
        for (int j = y - band; j <= y + band; ++j)
          for (int i = x - band; i <= x + band; ++i)
            if (i < 0 || j < 0 || i >= 60 || j >= 50 || ids(i, j) != id) return true;
        return false;
      };
      size_t both = 0, either = 0;
      for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 60; ++x) {
          if (truth(x, y) == 0) continue;
          const bool a = ring(ours, x, y), b = ring(truth, x, y);
          both += a && b;
          either += a || b;
        }
      EXPECT_EQ(count.both, both) << id;
      EXPECT_EQ(count.either, either) << id;
    }
  }
}

TEST(OverlapMatch, PairsIdsOneToOneByTheLargestIou) {
  OverlapMatch overlaps;
  overlaps.add(std::vector<uint32_t>{1, 1, 1, 2, 2, 0, 3}, std::vector<uint32_t>{9, 9, 9, 9, 8, 8, 0});
  const std::map<uint32_t, uint32_t> expected{{1, 9}, {2, 8}};
  EXPECT_EQ(overlaps.match(), expected);
}

}  // namespace
}  // namespace pliant
