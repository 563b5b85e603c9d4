// Extraction reports what each rule moved: on a scene made for one rule that rule fires alone, its count, its share of
// opacity and the rule of every Gaussian are those of the scene, and nothing is counted twice.

#include <gtest/gtest.h>

#include "segmentation/graph/convex_hull.h"
#include "segmentation/sheets/extract_sheet.h"
#include "tests/segmentation/certain.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

const std::vector<uint32_t> kIds = {3, 300, 70000};
constexpr float kOpacity = 0.95f;  // of every disc of a made scene

/// Counts by rule agree with the summary, only `fired` fired, and its share of opacity is that of `count` equal
/// Gaussians.
void expect_only(const ExtractResult& result, ExtractRule fired, size_t count, float opacity = kOpacity) {
  const ExtractSummary& s = result.summary;
  const size_t summary[kExtractRules] = {
      0,          s.below_probability, s.outliers, s.floaters, s.contact_to_support, s.contact_to_object,
      s.enclosed, s.islands,           s.hull};
  size_t counted[kExtractRules] = {};
  for (ExtractRule rule : result.rule) ++counted[static_cast<int>(rule)];
  for (int k = 1; k < kExtractRules; ++k) {
    const bool expected = k == static_cast<int>(fired);
    EXPECT_EQ(counted[k], expected ? count : 0u) << name_of(static_cast<ExtractRule>(k));
    EXPECT_EQ(summary[k], counted[k]) << name_of(static_cast<ExtractRule>(k));
    EXPECT_EQ(s.moved_by(static_cast<ExtractRule>(k)), summary[k]);
    EXPECT_NEAR(s.opacity_share[k], expected ? count * opacity / (s.candidates * kOpacity) : 0.0, 1e-3 / s.candidates)
        << k;
  }
  EXPECT_EQ(result.object.size() + result.background.size() + result.dropped.size(), result.rule.size());
}

ExtractResult extract_ball(const MadeScene& scene, const Segmentation& segmentation, bool hull = false) {
  ExtractOptions options;
  options.object = 300;
  options.support = MadeScene::kTable;
  options.hull = hull;
  return extract(options, scene.cloud, segmentation);
}

TEST(ExtractRules, NoneFiresOnACleanScene) {
  const MadeScene scene = made_scene(two_balls(), 1);
  const ExtractResult result = extract_ball(scene, certain(scene.truth, kIds));
  expect_only(result, ExtractRule::kNone, 0);
  EXPECT_TRUE(result.contact.found);
}

TEST(ExtractRules, AnOutlierAlone) {
  MadeScene scene = made_scene(two_balls(), 1);
  add_disc(scene.cloud, Vec3f(0.2f, 0.3f, 1.8f), Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
  scene.truth.push_back(300);
  const ExtractResult result = extract_ball(scene, certain(scene.truth, kIds));
  // It is a candidate itself, so the share is of one more.
  expect_only(result, ExtractRule::kOutlier, 1);
  EXPECT_EQ(result.dropped.size(), 1u);
}

TEST(ExtractRules, AFloaterAlone) {
  MadeScene scene = made_scene(two_balls(), 1);
  for (int i = 0; i < 9; ++i) {
    add_disc(scene.cloud, Vec3f(0.03f * (i % 3), 0.03f * (i / 3), 1.2f), Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
    scene.truth.push_back(300);
  }
  expect_only(extract_ball(scene, certain(scene.truth, kIds)), ExtractRule::kFloater, 9);
}

TEST(ExtractRules, WhatLiesUnderTheContactPlaneAlone) {
  MadeScene scene = made_scene(two_balls(), 1);
  const Vec3f c = scene.balls[0].centre;
  add_disc(scene.cloud, Vec3f(c.x() + 0.2245f, c.y(), -0.01f), Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
  scene.truth.push_back(300);
  expect_only(extract_ball(scene, certain(scene.truth, kIds)), ExtractRule::kToSupport, 1);
}

TEST(ExtractRules, AMissingPatchOfASurfaceIsNotInsideButWhatAHollowHoldsIs) {
  // A bowl: the ball without its cap; a pebble of another id lies in it, another beside it.
  MadeScene scene = made_scene(two_balls(), 1);
  const MadeScene::Ball ball = scene.balls[0];
  std::vector<int> keep;
  for (size_t p = 0; p < scene.cloud.size(); ++p)
    if (scene.truth[p] != 300 || scene.cloud.position[p].z() < ball.centre.z() + 0.5f * ball.radius)
      keep.push_back(static_cast<int>(p));
  std::vector<uint32_t> truth;
  for (int p : keep) truth.push_back(scene.truth[p]);
  scene.cloud = scene.cloud.select(keep);
  scene.truth = truth;
  for (int i = 0; i < 5; ++i) {
    add_disc(scene.cloud, ball.centre + Vec3f(0.03f * i - 0.06f, 0.0f, 0.02f), Vec3f::UnitZ(), 0.01f, Vec3f::Ones());
    add_disc(scene.cloud, ball.centre + Vec3f(0.03f * i - 0.06f, 1.3f * ball.radius, 0.1f), Vec3f::UnitZ(), 0.01f,
             Vec3f::Ones());
    scene.truth.insert(scene.truth.end(), {70000, 70000});
  }
  const Segmentation segmentation = certain(scene.truth, kIds);
  expect_only(extract_ball(scene, segmentation), ExtractRule::kNone, 0);
  const ExtractResult result = extract_ball(scene, segmentation, true);
  expect_only(result, ExtractRule::kHull, 5);
  for (int p : result.object) EXPECT_LT((scene.cloud.position[p] - ball.centre).norm(), 1.01f * ball.radius);
}

TEST(ExtractRules, SmallIslandsThatOnlyTheObjectHoldsAreItsUnlessTheyAreAnObjectThemselves) {
  const MadeScene plain = made_scene(two_balls(), 1);
  const MadeScene::Ball ball = plain.balls[0];
  const auto with_patch = [&](const Vec3f& at, uint32_t label) {
    MadeScene scene = plain;
    for (int i = 0; i < 9; ++i) {
      add_disc(scene.cloud, at + 0.03f * Vec3f(i % 3 - 1.0f, i / 3 - 1.0f, 0), Vec3f::UnitZ(), 0.01f, Vec3f::Ones());
      scene.truth.push_back(label);
    }
    return scene;
  };
  const std::vector<uint32_t> ids = {3, 5, 300, 70000};
  const auto extracted = [&](const MadeScene& scene) { return extract_ball(scene, certain(scene.truth, ids)); };
  const Vec3f above = ball.centre + Vec3f(0, 0, ball.radius + 0.045f);
  const ExtractResult taken = extracted(with_patch(above, 70000));
  expect_only(taken, ExtractRule::kIsland, 9, 0.95f);
  for (size_t p = plain.truth.size(); p < plain.truth.size() + 9; ++p) EXPECT_EQ(taken.rule[p], ExtractRule::kIsland);
  expect_only(extracted(with_patch(above, 5)), ExtractRule::kNone, 0);  // nothing else has its label
  expect_only(extracted(with_patch(above + Vec3f(0, 0, 0.5f), 70000)), ExtractRule::kNone, 0);  // far from the object
  expect_only(extracted(with_patch(ball.centre + Vec3f(0, 0.36f, -0.1f), 70000)), ExtractRule::kNone,
              0);  // the table holds it
}

TEST(ExtractRules, TheSheetShowsTheObjectInGreenAndAFloaterInItsColour) {
  MadeScene scene = made_scene(two_balls(), 1);
  const ExtractResult result = extract_ball(scene, certain(scene.truth, kIds));
  const ImageF sheet = extract_sheet(result, scene.cloud, Eigen::Vector3d::UnitZ(), {});
  EXPECT_EQ(sheet.width, 1600);
  const float* middle = sheet.at(200, 160);  // of the first side: the ball
  EXPECT_GT(middle[1], 0.4f);
  EXPECT_GT(middle[1], middle[2] + 0.2f);
}

TEST(ConvexHull, AgreesWithTheHalfSpacesOfABoxAndIsTheSameWhenThePointsAreTurned) {
  const Mat3f turn = Eigen::AngleAxisf(0.7f, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vec3f> corners, turned;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1 ? 1.0f : -1.0f, k & 2 ? 0.5f : -0.5f, k & 4 ? 0.2f : -0.2f);
  Random random(5);
  for (int k = 0; k < 50; ++k)  // points inside change nothing
    corners.emplace_back(random.uniform(-1, 1), random.uniform(-0.5, 0.5), random.uniform(-0.2, 0.2));
  for (const Vec3f& x : corners) turned.push_back(turn * x);
  const ConvexHull hull(corners), other(turned);
  constexpr float kMargin = 0.02f;
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3f x(random.uniform(-1.3, 1.3), random.uniform(-0.7, 0.7), random.uniform(-0.4, 0.4));
    const float depth = std::max({std::abs(x.x()) - 1, std::abs(x.y()) - 0.5f, std::abs(x.z()) - 0.2f});
    if (std::abs(depth) < kMargin) continue;
    inside += depth < 0;
    EXPECT_EQ(hull.contains(x), depth < 0) << x.transpose();
    EXPECT_EQ(other.contains(turn * x), depth < 0) << x.transpose();
  }
  EXPECT_GT(inside, 300);
}

}  // namespace
}  // namespace pliant
