#include "segmentation/select/gesture.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/error.h"
#include "gaussians/base/random.h"
#include "segmentation/sheets/selection_sheet.h"
#include "tests/segmentation/select/gesture_fixture.h"

using namespace pliant;

TEST(GrabCut, FindsADiscOfAnotherColourInsideALooseBox) {
  GrabCutInput input;
  input.width = 60;
  input.height = 50;
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 60; ++x) {
      const bool disc = (x - 30) * (x - 30) + (y - 25) * (y - 25) < 144;
      Random random(3, y * 60 + x);
      const Vec3f noise = 0.03f * Vec3f(random.normal(), random.normal(), random.normal());
      input.lab.push_back((disc ? Vec3f(0.5f, 0.4f, 0.2f) : Vec3f(0.6f, -0.1f, 0.1f)) + noise);
      input.seed.push_back(x > 12 && x < 50 && y > 6 && y < 44 ? PixelSeed::kUnknown : PixelSeed::kBackground);
    }
  const GrabCutResult result = grab_cut({}, input);
  size_t wrong = 0;
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 60; ++x)
      wrong += result.foreground[y * 60 + x] != ((x - 30) * (x - 30) + (y - 25) * (y - 25) < 144);
  EXPECT_LE(wrong, 6u);
}

TEST_F(GestureTest, TheCamerasThatDifferMostAreAmongAnyGreaterNumberOfThem) {
  const std::vector<Camera>& all = scene.cameras;
  ASSERT_GT(all.size(), 5u);
  std::vector<int> fewer;
  for (size_t count = 1; count <= all.size() + 2; ++count) {
    const std::vector<int> some = different_cameras(all, count);
    EXPECT_EQ(some.size(), std::min(count, all.size()));
    EXPECT_TRUE(std::ranges::is_sorted(some));
    EXPECT_TRUE(std::ranges::includes(some, fewer)) << count;
    fewer = some;
  }
  // Of a ring of cameras, the second looks from the other side.
  const std::vector<int> two = different_cameras(all, 2);
  EXPECT_EQ(two[0], 0);
  EXPECT_LT(all[two[1]].cam_from_world.linear().row(2).dot(all[0].cam_from_world.linear().row(2)), -0.5);
}

TEST_F(GestureTest, BoxesAroundABallSelectTheBall) {
  for (float loosen : {0.03f, 0.1f}) {
    Gesture gesture;
    for (int camera : {0, 3, 6}) gesture.boxes.push_back(box_of(300, camera, loosen));
    EXPECT_GT(iou(select(gesture), 300), 0.93) << loosen;
  }
  Gesture one;
  one.boxes.push_back(box_of(70000, 4, 0.05f));
  EXPECT_GT(iou(select(one), 70000), 0.85);
}

TEST_F(GestureTest, AClickSelectsTheClickedOfTwoBalls) {
  for (int ball : {0, 1}) {
    Gesture gesture;
    gesture.strokes.push_back({1, true, {centre_of(ball, 1)}, 6});
    EXPECT_GT(iou(select(gesture), scene.balls[ball].id), 0.85) << ball;
  }
}

TEST_F(GestureTest, GrowingAddsWhatTouchesAndShrinkingTakesTheBorder) {
  Gesture gesture;
  gesture.strokes.push_back({1, true, {centre_of(0, 1)}, 6});
  const GestureResult plain = select(gesture);
  size_t last = 0;
  for (const int rounds : {-2, -1, 0, 1, 2}) {
    gesture.grow = rounds;
    const GestureResult result = select(gesture);
    EXPECT_GT(result.summary.selected, last) << rounds;
    last = result.summary.selected;
    for (size_t p = 0; p < scene.truth.size(); ++p)
      if (rounds < 0 ? result.selected(p) : plain.selected(p)) {
        ASSERT_TRUE(rounds < 0 ? plain.selected(p) : result.selected(p)) << rounds << ", Gaussian " << p;
      }
  }
  // One round reaches no farther than the distance to a neighbour.
  gesture.grow = 1;
  const GestureResult one = select(gesture);
  for (size_t p = 0; p < scene.truth.size(); ++p) {
    if (!one.selected(p) || plain.selected(p)) continue;
    float nearest = INFINITY;
    for (size_t q = 0; q < scene.truth.size(); ++q)
      if (plain.selected(q)) nearest = std::min(nearest, (scene.cloud.position[p] - scene.cloud.position[q]).norm());
    EXPECT_LT(nearest, 0.15f);
  }
  // What a stroke marks stays as it says, though the rest goes from the border to the far side.
  gesture.grow = -30;
  const auto clicked = gesture.strokes;
  const GestureResult less = select(gesture);
  EXPECT_LT(less.summary.selected, plain.summary.selected / 2);
  const std::vector<size_t> under = nearest_to(centre_of(0, 1), 1, 300, 3);
  ASSERT_EQ(under.size(), 3u);
  for (const size_t p : under) EXPECT_TRUE(less.selected(p)) << "the click shows Gaussian " << p;
  gesture.strokes.push_back(clicked[0]);
  gesture.strokes.back().points = {centre_of(1, 1)};
  gesture.strokes.back().foreground = false;
  gesture.grow = 30;
  const GestureResult most = select(gesture);
  EXPECT_GT(most.summary.selected, 2 * plain.summary.selected);
  EXPECT_LT(most.summary.selected, scene.truth.size()) << "the stroke marks background";
  gesture.strokes = {};
  gesture.boxes = {box_of(300, 4, 0.05f)};
  const GestureResult boxed = select(gesture);
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (boxed.rule[p] == SelectionRule::kOutside) {
      ASSERT_FALSE(boxed.selected(p)) << "outside the box";
    }
}

TEST_F(GestureTest, GrowingDoesNotRunAlongLargeSparseGaussians) {
  // A column of large discs that touch each other stands beside the ball; a stroke marks its top as background.
  const MadeScene::Ball& ball = scene.balls[0];
  const size_t first = scene.cloud.size();
  for (int k = 0; k < 6; ++k)
    add_disc(scene.cloud, Vec3f(ball.centre.x() - ball.radius - 0.12f, ball.centre.y(), 0.05f + 0.2f * k),
             Vec3f::UnitX(), 0.1f, Vec3f(0.1f, 0.7f, 0.2f));
  scene.truth.resize(scene.cloud.size(), 0);
  Gesture gesture;
  Eigen::Vector2d top;
  project_point(scene.cameras[1], scene.cloud.position.back(), top);
  gesture.strokes = {{1, true, {centre_of(0, 1)}, 6}, {1, false, {top.cast<float>()}, 6}};
  const GestureResult plain = select(gesture);
  gesture.grow = 3;
  const GestureResult grown = select(gesture);
  EXPECT_GT(grown.summary.selected, plain.summary.selected + 10);
  for (size_t p = first; p < scene.cloud.size(); ++p) {
    ASSERT_FALSE(plain.selected(p)) << p - first;
    EXPECT_FALSE(grown.selected(p)) << p - first;
  }
}

TEST_F(GestureTest, ABackgroundStrokeRemovesALeak) {
  // A ball grows out of another of the same colour, and one box holds both: it is a leak until a stroke crosses it.
  auto balls = two_balls();
  balls[1].colour = balls[0].colour;
  balls[1].centre = Vec3f(0.06f, 0.1f, 0.15f);
  scene = made_scene(balls);
  Gesture gesture;
  BoxPrompt a = box_of(300, 0, 0.05f), b = box_of(70000, 0, 0.05f);
  gesture.boxes.push_back({0, std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)});
  const double before = iou(select(gesture), 300);
  const Vec2f centre = centre_of(1, 1);
  gesture.strokes.push_back({1, false, {centre - Vec2f(4, 0), centre + Vec2f(4, 0)}, 6});
  const GestureResult after = select(gesture);
  EXPECT_GT(after.summary.seeds, 5u);
  EXPECT_LT(before, 0.8);
  EXPECT_GT(iou(after, 300), before + 0.1);
}

TEST_F(GestureTest, WhatAStrokeCoversIsFixed) {
  Gesture gesture;
  gesture.boxes.push_back(box_of(300, 0, 0.3f));
  const Vec2f table = centre_of(0, 0) + Vec2f(0, 0.6f * (gesture.boxes[0].y1 - gesture.boxes[0].y0) / 1.6f + 4);
  gesture.strokes.push_back({0, true, {table}, 4});
  const GestureResult with = select(gesture);
  EXPECT_GT(with.summary.seeds, 0u);
  size_t table_selected = 0;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    table_selected += with.selected(p) && scene.truth[p] == MadeScene::kTable;
  EXPECT_GT(table_selected, 0u);
}

TEST_F(GestureTest, AShapeBoundsTheSelection) {
  Gesture gesture;
  gesture.boxes.push_back(box_of(300, 0, 0.05f));
  const SelectionShape shape = SelectionShape::from_sphere({-0.35, 0.1, 0.3, 0.2});
  const GestureResult result = select(gesture, shape);
  for (size_t p = 0; p < scene.truth.size(); ++p)
    EXPECT_TRUE(!result.selected(p) || shape.contains(scene.cloud.position[p]));
}

TEST_F(GestureTest, EqualForAnyNumberOfThreads) {
  Gesture gesture;
  gesture.boxes.push_back(box_of(300, 0, 0.08f));
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const GestureResult one = select(gesture);
  omp_set_num_threads(3);
  const GestureResult three = select(gesture);
  omp_set_num_threads(threads);
  EXPECT_EQ(one.probability, three.probability);
  EXPECT_EQ(one.rule, three.rule);
}

TEST_F(GestureTest, EveryGaussianHasOneRuleAndTheSheetShowsThem) {
  Gesture gesture;
  gesture.boxes.push_back(box_of(300, 0, 0.05f));
  const GestureResult result = select(gesture);
  const auto& s = result.summary;
  EXPECT_EQ(s.selected + s.outside + s.cut + s.part + s.refined, scene.truth.size());
  for (size_t p = 0; p < scene.truth.size(); ++p) EXPECT_EQ(result.selected(p), result.rule[p] == SelectionRule::kKept);
  std::vector<int> selected;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (result.selected(p)) selected.push_back(static_cast<int>(p));
  const ImageF sheet = selection_sheet(result, scene.cloud, sheet_sides(scene.cloud.select(selected), {0, 0, 1}));
  size_t green = 0;
  for (int y = 0; y < sheet.height - 60; ++y)
    for (int x = 0; x < sheet.width; ++x) green += sheet(x, y, 1) > 0.4f && sheet(x, y, 1) > 1.3f * sheet(x, y, 2);
  EXPECT_GT(green, 5000u);
}

// Photos that are named by numbers: 1 is the name of the first, #1 the second whatever the names are.
TEST_F(GestureTest, AMarkedNumberIsTheIndexOfACamera) {
  std::vector<Camera> cameras(scene.cameras.begin(), scene.cameras.begin() + 3);
  for (int c = 0; c < 3; ++c) cameras[c].name = std::to_string(c + 1);
  Gesture gesture;
  add_click("1,5,5", cameras, 8, gesture);
  add_click("#1,5,5", cameras, 8, gesture);
  add_stroke("bg,#2,1,1,9,9", cameras, 8, gesture);
  add_click("0,5,5", cameras, 8, gesture);
  add_box("#0,1,1,20,20", cameras, gesture);
  ASSERT_EQ(gesture.strokes.size(), 4u);
  for (const auto& [k, camera] : {std::pair(0, 0), {1, 1}, {2, 2}, {3, 0}})
    EXPECT_EQ(gesture.strokes[k].camera, camera);
  EXPECT_EQ(gesture.boxes[0].camera, 0);
  for (const char* bad : {"#,5,5", "#3,5,5", "#-1,5,5", "#x,5,5"})
    EXPECT_NE(complaint([&] { add_click(bad, cameras, 8, gesture); }).find("#0 to #2"), std::string::npos) << bad;
}

TEST_F(GestureTest, TheNameOfACameraMayHoldCommas) {
  std::vector<Camera> cameras(scene.cameras.begin(), scene.cameras.begin() + 3);
  cameras[0].name = "a";
  cameras[1].name = "a,b";
  cameras[2].name = "a,b,2";
  Gesture gesture;
  add_box("a,b,1,1,20,20", cameras, gesture);
  add_click("a,b,2,5,6", cameras, 8, gesture);
  add_stroke("bg,a,b,1,1,9,9", cameras, 8, gesture);
  add_click("a,5,6", cameras, 8, gesture);
  EXPECT_EQ(gesture.boxes.at(0).camera, 1);
  ASSERT_EQ(gesture.strokes.size(), 3u);
  for (const auto& [k, camera] : {std::pair(0, 2), {1, 1}, {2, 0}}) EXPECT_EQ(gesture.strokes[k].camera, camera);
  EXPECT_EQ(gesture.strokes[0].points[0], Vec2f(5, 6));
  EXPECT_EQ(gesture.strokes[1].points.size(), 2u);
}

TEST_F(GestureTest, MalformedOptionsNameOptionValueAndRemedy) {
  Gesture gesture;
  const auto& cameras = scene.cameras;
  const std::pair<std::string, std::string> boxes[] = {
      {"view99,1,1,20,20", "view99"}, {"99,1,1,20,20", "99"},         {"0,1,1,20,400", "outside"},
      {"0,-5,1,20,40", "outside"},    {"0,10,10,10,40", "less than"}, {"0,10,10,40", "4 values"},
      {"0,1,2,3,4,5", "6 values"},    {"0,1,x,30,40", "'x'"},         {"", "values"}};
  for (const auto& [text, what] : boxes) {
    const std::string said = complaint([&] { add_box(text, cameras, gesture); });
    EXPECT_NE(said.find("--box"), std::string::npos) << text;
    EXPECT_NE(said.find(what), std::string::npos) << text << " -> " << said;
  }
  EXPECT_TRUE(gesture.empty());
  add_box("view0,1,1,20,20", cameras, gesture);
  EXPECT_NE(complaint([&] { add_box("0,2,2,30,30", cameras, gesture); }).find("second box"), std::string::npos);
  EXPECT_NE(complaint([&] { add_click("0,5", cameras, 8, gesture); }).find("--click"), std::string::npos);
  EXPECT_NE(complaint([&] { add_click("0,5,nan", cameras, 8, gesture); }).find("nan"), std::string::npos);
  EXPECT_NE(complaint([&] { add_stroke("up,0,1,1,2,2", cameras, 8, gesture); }).find("'up'"), std::string::npos);
  EXPECT_NE(complaint([&] { add_stroke("fg,0,1,1,2", cameras, 8, gesture); }).find("--stroke"), std::string::npos);
  EXPECT_NE(complaint([&] { add_stroke("bg,0,1,1,2,2,3", cameras, 8, gesture); }).find("even"), std::string::npos);
  add_stroke("bg,view1,1,1,2,2,3,3", cameras, 8, gesture);
  ASSERT_EQ(gesture.strokes.size(), 1u);
  EXPECT_EQ(gesture.strokes[0].points.size(), 3u);
  EXPECT_FALSE(gesture.strokes[0].foreground);
}
