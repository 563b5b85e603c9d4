// What hangs together with what was clicked, or with the part of a thing that colours find in a box.

#include <gtest/gtest.h>

#include "gaussians/base/random.h"
#include "tests/segmentation/select/gesture_fixture.h"

using namespace pliant;

TEST_F(GestureTest, AClickTakesAThingOfManyColoursWholeFromThePlaneBehindIt) {
  paint_stripes(300);
  options.up = Vec3f::Zero();  // it may hang at a wall
  for (int camera : {1, 4, 8}) {
    Gesture gesture;
    gesture.strokes.push_back({camera, true, {centre_of(0, camera)}, 4});
    options.apart_from_planes = true;
    EXPECT_GT(iou(select(gesture), 300), 0.85) << camera;
    options.apart_from_planes = false;
    EXPECT_LT(iou(select(gesture), 300), 0.7) << camera;
  }
}

// People draw boxes that a thing fills: where colours find one part of it, what hangs together with that part counts.
TEST_F(GestureTest, ABoxTakesAThingWholeOfWhichColoursFindOnePart) {
  const Vec3f bright(0.9f, 0.9f, 0.1f), like_the_table(0.62f, 0.46f, 0.3f);
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == 300)
      for (int k = 0; k < 3; ++k) {
        const bool top = scene.cloud.position[p].z() > scene.balls[0].centre.z() + 0.2f * scene.balls[0].radius;
        scene.cloud.sh_of(p)[k] = ((top ? bright : like_the_table)[k] - 0.5f) / kSh0;
      }
  for (int camera : {1, 4, 8}) {
    Gesture gesture;
    gesture.boxes.push_back(box_of(300, camera, 0.05f));
    options.apart_from_planes = true;
    const GestureResult whole = select(gesture);
    EXPECT_GT(iou(whole, 300), 0.85) << camera;
    size_t selected = 0;
    for (size_t p = 0; p < scene.truth.size(); ++p) {
      selected += whole.selected(p);
      EXPECT_EQ(whole.selected(p), whole.rule[p] == SelectionRule::kKept) << p;
    }
    EXPECT_EQ(whole.summary.selected, selected);
    // A stroke over the table does not take the thing apart again.
    gesture.strokes.push_back(
        {camera, false, {centre_of(0, camera) + Vec2f(0, 24), centre_of(0, camera) + Vec2f(8, 24)}, 3});
    EXPECT_GT(iou(select(gesture), 300), 0.8) << camera;
    gesture.strokes.clear();
    options.apart_from_planes = false;
    EXPECT_LT(iou(select(gesture), 300), 0.7) << camera;
  }
  // The view of the box is looked at although others are prepared.
  options.apart_from_planes = true;
  prepare.most_views = 2;
  const PreparedScene prepared = prepare_scene(prepare, scene.cloud, scene.cameras);
  for (int camera = 0; camera < static_cast<int>(scene.cameras.size()); ++camera) {
    if (prepared.view_of(camera)) continue;
    Gesture gesture;
    gesture.boxes.push_back(box_of(300, camera, 0.05f));
    const std::vector<int> looked = select(gesture).summary.refine_views;
    EXPECT_EQ(std::count(looked.begin(), looked.end(), camera), 1) << camera;
    break;
  }
}

// A box that is much too large takes what colours find, not that and what it touches.
TEST_F(GestureTest, ALooseBoxAroundAThingThatTouchesAnotherTakesItAlone) {
  const Vec3f together = scene.balls[0].centre - scene.balls[1].centre;
  const Vec3f aside = (scene.balls[0].radius + scene.balls[1].radius) * Vec3f(0.6f, -0.8f, 0);
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == 70000) scene.cloud.position[p] += together + aside;
  for (int camera : {1, 4, 8}) {
    Gesture gesture;
    gesture.boxes.push_back(box_of(300, camera, 0.25f));
    EXPECT_GT(iou(select(gesture), 300), 0.85) << camera;
  }
}

// A click in a gap covers the leaves around it and the wall far behind: it means the one of which it covers most.
TEST_F(GestureTest, AClickMeansOneSurface) {
  const Camera& camera = scene.cameras[4];
  const Vec2f at = centre_of(0, 4);
  const size_t wall = scene.cloud.size();
  const Vec3f behind =
      camera.centre().cast<float>() + 3 * (scene.balls[0].centre.cast<float>() - camera.centre().cast<float>());
  for (int k = 0; k < 400; ++k)
    add_disc(scene.cloud,
             behind + 0.2f * Vec3f(static_cast<float>(k % 20) - 9.5f, 0, static_cast<float>(k / 20) - 9.5f),
             Vec3f::UnitY(), 0.15f, Vec3f(0.2f, 0.2f, 0.9f));
  scene.truth.resize(scene.cloud.size(), 0);
  // The ball has a hole of three pixels under the click.
  for (size_t p = 0; p < wall; ++p) {
    Eigen::Vector2d x;
    if (project_point(camera, scene.cloud.position[p], x) && (x.cast<float>() - at).norm() < 1.5f)
      scene.cloud.opacity_logit[p] = -12;
  }
  Gesture gesture;
  gesture.strokes.push_back({4, true, {at}, 8});
  const GestureResult result = select(gesture);
  size_t of_wall = 0;
  for (size_t p = wall; p < scene.cloud.size(); ++p) of_wall += result.selected(p);
  EXPECT_EQ(of_wall, 0u);
  EXPECT_GT(iou(result, 300), 0.8);
}

TEST_F(GestureTest, AClickTakesAThingFromATableThatIsSmallInItsScene) {
  paint_stripes(300);
  for (int k = 0; k < 14400; ++k)  // a floor around the table
    add_disc(scene.cloud, Vec3f(-9 + 0.15f * (k % 120), -9 + 0.15f * (k / 120), -2), Vec3f::UnitZ(), 0.09f,
             Vec3f(0.3f, 0.5f, 0.2f));
  scene.truth.resize(scene.cloud.size(), 0);
  for (int camera : {1, 4, 8}) {
    Gesture gesture;
    gesture.strokes.push_back({camera, true, {centre_of(0, camera)}, 4});
    EXPECT_GT(iou(select(gesture), 300), 0.85) << camera;
  }
}

// A rough table with floaters below it: wherever a ball is clicked, the table is the plane that it stands on.
TEST_F(GestureTest, FloatersBelowARoughPlaneDoNotHideIt) {
  paint_stripes(300);
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == MadeScene::kTable)
      scene.cloud.position[p].z() += 0.012f * static_cast<float>(Random(3, p).normal());
  for (int k = 0; k < 60; ++k) {
    Random random(4, k);
    add_disc(scene.cloud,
             Vec3d(random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9), random.uniform(-0.8, -0.2)).cast<float>(),
             Vec3f::UnitZ(), 0.15f, Vec3f(0.5f, 0.5f, 0.5f));
  }
  scene.truth.resize(scene.cloud.size(), 0);
  for (int camera : {1, 4, 8})
    for (const float lift : {-6.0f, 0.0f, 6.0f}) {
      Gesture gesture;
      gesture.strokes.push_back({camera, true, {centre_of(0, camera) - lift * Vec2f::UnitY()}, 4});
      EXPECT_GT(iou(select(gesture), 300), 0.85) << camera << " " << lift;
    }
}

// However much colours count, a click does not take another thing that looks the same.
TEST_F(GestureTest, AClickLeavesWhatOnlyLooksTheSame) {
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] != MadeScene::kTable)
      for (int k = 0; k < 3; ++k) scene.cloud.sh_of(p)[k] = (0.9f * (k == 0) + 0.05f - 0.5f) / kSh0;
  options.cut.color *= 30;
  options.refine_cut.color *= 30;
  for (int ball : {0, 1}) {
    Gesture gesture;
    gesture.strokes.push_back({4, true, {centre_of(ball, 4)}, 4});
    EXPECT_GT(iou(select(gesture), scene.balls[ball].id), 0.8) << ball;
  }
}

TEST_F(GestureTest, AFurtherMarkAddsAThingOfItsSizeButOnlyAPatchOfALargerOne) {
  Gesture gesture;
  gesture.strokes.push_back({1, true, {centre_of(0, 1)}, 4});
  const double one = iou(select(gesture), 300);
  EXPECT_GT(one, 0.85);
  Eigen::Vector2d x;
  project_point(scene.cameras[1], scene.balls[0].centre + Vec3f(0, scene.balls[0].radius + 0.12f, 0), x);
  gesture.strokes.push_back({1, true, {x.cast<float>()}, 4});  // the table beside it
  const GestureResult patch = select(gesture);
  size_t table = 0, taken = 0, ball = 0, kept = 0;
  for (size_t p = 0; p < scene.truth.size(); ++p) {
    const bool of_table = scene.truth[p] == MadeScene::kTable, of_ball = scene.truth[p] == 300;
    table += of_table;
    taken += of_table && patch.selected(p);
    ball += of_ball;
    kept += of_ball && patch.selected(p);
  }
  EXPECT_GT(taken, 0u);
  EXPECT_LT(taken, table / 5);
  EXPECT_GT(kept, 0.9 * one * ball);
  gesture.strokes[1].points = {centre_of(1, 1)};
  const GestureResult both = select(gesture);
  for (size_t k = 0; k < 2; ++k) {
    size_t count = 0, found = 0;
    for (size_t p = 0; p < scene.truth.size(); ++p)
      if (scene.truth[p] == scene.balls[k].id) {
        ++count;
        found += both.selected(p);
      }
    EXPECT_GT(found, 0.85 * count) << k;
  }
}
