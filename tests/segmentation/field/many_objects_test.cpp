// More objects than channels of the attribute: all are found, with any id, and nothing depends on the order of the
// views.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "segmentation/associate/associate.h"
#include "segmentation/field/islands.h"
#include "segmentation/field/semantic_field.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

const MadeScene& grid() {
  static const MadeScene scene = made_scene(grid_of_balls(6), 8, 240, 180, 0.03f, 0.02f);
  return scene;
}

Segmentation fitted(const MadeScene& scene, const MaskSet& masks, int iterations = 60) {
  SemanticOptions options;
  options.iterations = iterations;
  Segmentation segmentation = fit_semantic_field(options, scene.cloud, scene.cameras, masks).segmentation;
  merge_islands({}, scene.cloud, segmentation);
  return segmentation;
}

/// Whether Gaussian p is the table's and lies under a ball, where cameras see it past the ball's edge at most.
bool under_a_ball(const MadeScene& scene, size_t p) {
  return std::any_of(scene.balls.begin(), scene.balls.end(), [&](const auto& b) {
    return scene.truth[p] != b.id && scene.cloud.position[p].z() < b.centre.z() &&
           (scene.cloud.position[p] - b.centre).template head<2>().norm() < b.radius;
  });
}

TEST(ManyObjects, ThirtySixBallsAndATableAreAllFoundInSixteenChannels) {
  const MadeScene& scene = grid();
  const MaskSet masks = cast_masks(scene);
  const Segmentation segmentation = fitted(scene, masks);
  ASSERT_EQ(segmentation.class_id.size(), 37u);
  std::map<uint32_t, size_t> right, total;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (segmentation.seen[p] && !under_a_ball(scene, p)) {
      ++total[scene.truth[p]];
      right[scene.truth[p]] += segmentation.label[p] == scene.truth[p];
    }
  for (const auto& [id, count] : total) EXPECT_GT(right[id], 0.9 * count) << id;
  const std::vector<ObjectEntry> objects = list_objects(segmentation, scene.cloud.position);
  for (const ObjectEntry& object : objects) {
    EXPECT_GT(object.views, 4) << object.id;
    const auto ball =
        std::find_if(scene.balls.begin(), scene.balls.end(), [&](const auto& b) { return b.id == object.id; });
    if (ball == scene.balls.end()) continue;
    // The 2nd to 98th percentile of what stands above the table.
    EXPECT_LT((0.5f * (object.bounds.low + object.bounds.high) - ball->centre).head<2>().norm(), 0.3f * ball->radius)
        << object.id;
  }
  std::vector<IdImage> truth, predicted;
  for (int c : {0, 3}) {
    truth.push_back(cast_ids(scene, scene.cameras[c]));
    predicted.push_back(render_ids(segmentation, scene.cloud, scene.cameras[c]));
  }
  EXPECT_GT(id_agreement(predicted, truth).mean, 0.85);
}

TEST(ManyObjects, IdsShuffledInEveryViewAreFoundAgain) {
  const MadeScene& scene = grid();
  MaskSet masks = cast_masks(scene);
  for (MaskSet::View& view : masks.views)
    for (uint32_t& id : view.ids.data)
      if (id != 0) id = 1 + (id * 2654435761u + static_cast<uint32_t>(view.camera) * 40503u) % 8000000u;
  const AssociateResult result = associate({}, scene.cloud, scene.cameras, masks);
  EXPECT_EQ(result.summary.groups, 37);
}

TEST(ManyObjects, ObjectsAreTheSameForAnyOrderOfTheViews) {
  const MadeScene& scene = grid();
  MaskSet masks = cast_masks(scene), turned = masks;
  std::reverse(turned.views.begin(), turned.views.end());
  std::rotate(turned.views.begin(), turned.views.begin() + 3, turned.views.end());
  const Segmentation a = fitted(scene, masks, 10), b = fitted(scene, turned, 10);
  EXPECT_EQ(a.class_id, b.class_id);
  EXPECT_EQ(a.label, b.label);
  EXPECT_EQ(a.class_cameras, b.class_cameras);
}

TEST(ManyObjects, AnObjectThatLeavesAndComesBackKeepsItsIdAndIsCountedWhereItWasSeen) {
  const MadeScene& scene = grid();
  MaskSet masks = cast_masks(scene);
  const uint32_t away = scene.balls[14].id;
  for (int view : {2, 3, 4})
    for (uint32_t& id : masks.views[view].ids.data)
      if (id == away) id = 0;
  const Segmentation segmentation = fitted(scene, masks, 0);
  const std::vector<int>& cameras = segmentation.class_cameras[class_of_id(segmentation, away)];
  EXPECT_EQ(cameras, (std::vector<int>{0, 1, 5, 6, 7}));
}

}  // namespace
}  // namespace pliant
