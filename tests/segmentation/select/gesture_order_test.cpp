// Marks one after the other: which counts, and what is known of the first ones.

#include "tests/segmentation/select/gesture_fixture.h"

namespace pliant {
namespace {

struct GestureOrder : GestureTest {
  const PreparedScene prepared = prepare_scene(prepare, scene.cloud, scene.cameras);
  GestureSteps steps;

  GestureResult ask(const Gesture& gesture, GestureSteps* known = nullptr) const {
    return select_by_gesture(options, gesture, {}, scene.cloud, scene.cameras, prepared, known);
  }
  StrokePrompt mark(int ball, int camera, bool foreground) const {
    const Vec2f centre = centre_of(ball, camera);
    return {camera, foreground, {centre, centre + Vec2f(3, 0)}, 6};
  }
};

TEST_F(GestureOrder, WhatIsKnownOfTheFirstStrokesChangesNoResult) {
  Gesture box;
  box.boxes.push_back(box_of(300, 0, 0.2f));
  const auto with = [&](const std::vector<StrokePrompt>& strokes, int grow = 0) {
    Gesture gesture = box;
    gesture.strokes = strokes;
    gesture.grow = grow;
    return gesture;
  };
  const StrokePrompt a = mark(0, 1, true), b = mark(1, 1, false), c = mark(0, 4, true);
  Gesture other = with({a});
  other.boxes[0].x1 += 3;
  Gesture unboxed = with({a, b});
  unboxed.boxes.clear();
  const std::vector<Gesture> questions = {with({}),     with({a}),    with({a, b}),    with({a}),
                                          with({a}, 2), with({a, c}), with({a, c, b}), with({c}, -1),
                                          other,        unboxed,      with({a, b})};
  std::vector<GestureResult> anew;
  for (const Gesture& gesture : questions) anew.push_back(ask(gesture));
  for (const size_t most : {32, 2}) {
    steps = {.most = most};
    for (size_t k = 0; k < questions.size(); ++k) {
      const GestureResult known = ask(questions[k], &steps);
      EXPECT_EQ(known.probability, anew[k].probability) << k;
      EXPECT_EQ(known.rule, anew[k].rule) << k;
      EXPECT_EQ(known.summary.describe(), anew[k].summary.describe()) << k;
      EXPECT_LE(steps.steps.size(), most);
    }
  }
}

TEST_F(GestureOrder, AStrokeMoreGoesOnFromTheKnownOnesAndOneLessIsKnown) {
  Gesture gesture;
  gesture.boxes.push_back(box_of(300, 0, 0.2f));
  gesture.strokes = {mark(0, 1, true), mark(1, 1, false)};
  ask(gesture, &steps);
  ASSERT_EQ(steps.steps.size(), 3u);
  // A mark by which the known result is told from the same one found anew.
  constexpr double kMarked = 1e6;
  steps.steps.at(1).result.summary.seconds = kMarked;
  gesture.strokes.pop_back();
  EXPECT_EQ(ask(gesture, &steps).summary.seconds, kMarked) << "undone";
  EXPECT_EQ(steps.steps.size(), 3u) << "it can be made again";
  gesture.strokes.push_back(mark(0, 4, true));
  EXPECT_GT(ask(gesture, &steps).summary.seconds, kMarked) << "goes on from there";
  EXPECT_EQ(steps.steps.size(), 3u);
}

TEST_F(GestureOrder, ALaterClickCountsOverAStrokeAndAnEarlierOneUnderItIsWarnedOf) {
  const Vec2f centre = centre_of(0, 1);
  const StrokePrompt click{1, true, {centre}, 6}, elsewhere{4, true, {centre_of(0, 4)}, 6};
  const StrokePrompt over{1, false, {centre - Vec2f(2, 0), centre + Vec2f(2, 0)}, 10};
  Gesture gesture;
  gesture.strokes = {elsewhere, click, over};
  const auto warnings = ask(gesture).summary.warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("'" + scene.cameras[1].name + "' has no effect"), std::string::npos) << warnings[0];
  gesture.strokes = {elsewhere, over};
  add_stroke("fg,1," + std::to_string(centre.x()) + "," + std::to_string(centre.y()), scene.cameras, 6, gesture);
  ASSERT_EQ(gesture.strokes.back().points.size(), 1u);
  const GestureResult later = ask(gesture);
  EXPECT_TRUE(later.summary.warnings.empty());
  const std::vector<size_t> under = nearest_to(centre, 1, 300, 3);
  ASSERT_EQ(under.size(), 3u);
  for (const size_t p : under) EXPECT_TRUE(later.selected(p)) << p;
}

}  // namespace
}  // namespace pliant
