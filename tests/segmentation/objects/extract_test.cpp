// Each rule of extraction on an example made for it; the plane under an object.

#include "segmentation/objects/extract.h"

#include <functional>
#include <numeric>

#include "gaussians/base/linear_algebra.h"
#include "segmentation/field/islands.h"
#include "tests/segmentation/certain.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

const std::vector<uint32_t> kObjectIds = {3, 300, 70000};

TEST(Extract, TakesExactlyTheObjectOfACleanScene) {
  const MadeScene scene = made_scene(two_balls(), 1);
  ExtractOptions options;
  options.object = 300;
  const ExtractResult result = extract(options, scene.cloud, certain(scene.truth, kObjectIds));
  std::vector<int> expected;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == 300) expected.push_back(static_cast<int>(p));
  EXPECT_EQ(result.object, expected);
  EXPECT_EQ(result.summary.support, MadeScene::kTable);
  EXPECT_EQ(result.object.size() + result.background.size() + result.dropped.size(), scene.cloud.size());
}

TEST(Extract, ProbabilityBelowTheThresholdStaysInTheBackground) {
  const MadeScene scene = made_scene(two_balls(), 1);
  Segmentation segmentation = certain(scene.truth, kObjectIds);
  // Three Gaussians of the ball in the middle between all classes, a little nearer to their own: p about 0.4.
  std::vector<int> doubtful;
  for (size_t p = 0; p < scene.truth.size() && doubtful.size() < 3; ++p)
    if (scene.truth[p] == 300) doubtful.push_back(static_cast<int>(p));
  for (int p : doubtful)
    for (int k = 0; k < kSemanticChannels; ++k) segmentation.attribute[p * kSemanticChannels + k] *= 0.03f;
  update_labels(segmentation);
  ExtractOptions options;
  options.object = 300;
  options.enclosed = false;
  options.island_share = 0;
  const ExtractResult result = extract(options, scene.cloud, segmentation);
  EXPECT_EQ(result.summary.below_probability, 3u);
  for (int p : doubtful) EXPECT_TRUE(std::binary_search(result.background.begin(), result.background.end(), p));

  // They lie on the ball among its other Gaussians, so the last rule takes them along.
  options.enclosed = true;
  const ExtractResult whole = extract(options, scene.cloud, segmentation);
  EXPECT_EQ(whole.summary.enclosed, 3u);
  for (int p : doubtful) EXPECT_TRUE(std::binary_search(whole.object.begin(), whole.object.end(), p));
}

TEST(Islands, APatchOfAnotherLabelOnABallIsMergedAndARealBallIsNot) {
  const MadeScene scene = made_scene(two_balls(), 1);
  std::vector<uint32_t> label = scene.truth;
  // The side of the ball away from the table's middle is labelled as the table, which it does not touch.
  size_t patch = 0;
  for (size_t p = 0; p < label.size(); ++p)
    if (scene.truth[p] == 300 &&
        scene.cloud.position[p].z() > 0.8f * scene.balls[0].radius + scene.balls[0].centre.z()) {
      label[p] = MadeScene::kTable;
      ++patch;
    }
  ASSERT_GT(patch, 3u);
  Segmentation segmentation = certain(label, kObjectIds);
  EXPECT_EQ(merge_islands({}, scene.cloud, segmentation), patch);
  EXPECT_EQ(segmentation.label, scene.truth);
  EXPECT_EQ(merge_islands({}, scene.cloud, segmentation), 0u);
}

TEST(Extract, OutliersInTheAirAreDroppedAndThoseInTheTableStayThere) {
  MadeScene scene = made_scene(two_balls(), 1);
  for (const Vec3f& x : {Vec3f(0.0f, 0.0f, 2.0f), Vec3f(0.5f, 0.4f, 1.5f)}) {
    add_disc(scene.cloud, x, Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
    scene.truth.push_back(300);
  }
  const int mislabelled = 5;
  ASSERT_EQ(scene.truth[mislabelled], MadeScene::kTable);
  scene.truth[mislabelled] = 300;  // a corner of the table
  ExtractOptions options;
  options.object = 300;
  const ExtractResult result = extract(options, scene.cloud, certain(scene.truth, kObjectIds));
  EXPECT_EQ(result.summary.outliers, 3u);
  const int n = static_cast<int>(scene.cloud.size());
  EXPECT_EQ(result.dropped, (std::vector<int>{n - 2, n - 1}));
  EXPECT_TRUE(std::binary_search(result.background.begin(), result.background.end(), mislabelled));
}

TEST(Extract, SmallDisconnectedPartsAreFloaters) {
  MadeScene scene = made_scene(two_balls(), 1);
  for (int i = 0; i < 9; ++i) {  // a clump, dense enough to be no outlier
    add_disc(scene.cloud, Vec3f(0.03f * (i % 3), 0.03f * (i / 3), 1.2f), Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
    scene.truth.push_back(300);
  }
  ExtractOptions options;
  options.object = 300;
  const ExtractResult result = extract(options, scene.cloud, certain(scene.truth, kObjectIds));
  EXPECT_EQ(result.summary.outliers, 0u);
  EXPECT_EQ(result.summary.floaters, 9u);
  EXPECT_EQ(result.dropped.size(), 9u);
}

TEST(Extract, GaussiansAtTheContactGoToTheSideOfThePlaneTheyLieOn) {
  MadeScene scene = made_scene(two_balls(), 1);
  // Below the table at the ball's rim, labelled ball; on the ball a little above the table, labelled table.
  const Vec3f c = scene.balls[0].centre;
  add_disc(scene.cloud, Vec3f(c.x() + 0.2245f, c.y(), -0.01f), Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
  scene.truth.push_back(300);
  int raised = -1;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == 300 && std::abs(scene.cloud.position[p].z() - 0.036f) < 0.004f) raised = static_cast<int>(p);
  ASSERT_GE(raised, 0);
  scene.truth[raised] = MadeScene::kTable;
  ExtractOptions options;
  options.object = 300;
  options.support = MadeScene::kTable;
  const ExtractResult result = extract(options, scene.cloud, certain(scene.truth, kObjectIds));
  EXPECT_EQ(result.summary.contact_to_support, 1u);
  EXPECT_EQ(result.summary.contact_to_object, 1u);
  EXPECT_TRUE(std::binary_search(result.object.begin(), result.object.end(), raised));
  EXPECT_FALSE(
      std::binary_search(result.object.begin(), result.object.end(), static_cast<int>(scene.cloud.size()) - 1));
}

TEST(Extract, NothingStandsOnItself) {
  const MadeScene scene = made_scene(two_balls(), 1);
  Segmentation segmentation = certain(scene.truth, kObjectIds);
  ExtractOptions options;
  options.object = MadeScene::kTable;
  const ExtractResult unnamed = extract(options, scene.cloud, segmentation);
  options.support = MadeScene::kTable;
  const ExtractResult named = extract(options, scene.cloud, segmentation);
  EXPECT_NE(named.summary.support, MadeScene::kTable);
  EXPECT_EQ(named.summary.support, unnamed.summary.support);
  EXPECT_EQ(named.object, unnamed.object);
  EXPECT_EQ(named.background, unnamed.background);

  // The lower end of the ball is too doubtful to be cut out, and no support either.
  for (size_t p = 0; p < scene.truth.size(); ++p)
    if (scene.truth[p] == 300 && scene.cloud.position[p].z() < 0.06f)
      for (int k = 0; k < kSemanticChannels; ++k) segmentation.attribute[p * kSemanticChannels + k] *= 0.03f;
  update_labels(segmentation);
  options = {};
  options.object = 300;
  const ExtractResult ball = extract(options, scene.cloud, segmentation);
  EXPECT_GT(ball.summary.below_probability, 50u);
  EXPECT_EQ(ball.summary.support, MadeScene::kTable);
}

// Gaussian Grouping trains ID 0 as an object, often the table.
TEST(Extract, AnObjectWithIdZeroCarriesLikeAnyOther) {
  const MadeScene scene = made_scene(two_balls(), 1);
  std::vector<uint32_t> zero = scene.truth;
  std::replace(zero.begin(), zero.end(), MadeScene::kTable, 0u);
  const Segmentation segmentation = certain(zero, {0, 300, 70000});
  ExtractOptions options;
  options.object = 300;
  const ExtractResult table = extract(options, scene.cloud, certain(scene.truth, kObjectIds)),
                      found = extract(options, scene.cloud, segmentation);
  EXPECT_EQ(found.summary.support, std::optional<uint32_t>(0));
  EXPECT_TRUE(found.contact.found);
  EXPECT_EQ(found.object, table.object);
  // Named it carries although it is known as no support; sought it does not.
  options.supports.emplace();
  EXPECT_FALSE(extract(options, scene.cloud, segmentation).summary.support.has_value());
  options.support = 0u;
  const ExtractResult named = extract(options, scene.cloud, segmentation);
  EXPECT_EQ(named.summary.support, std::optional<uint32_t>(0));
  EXPECT_TRUE(named.contact.found);
}

/// A figure on a plinth, of one splat: its lower end is the plinth, `level` is where the rest lies about it.
MadeScene figure(const std::function<bool(const Vec3f& x)>& rest, float level) {
  MadeScene scene;
  for (float z = 0; z <= 1; z += 0.02f)
    for (int k = 0; k < 40; ++k) {
      const float angle = 2 * static_cast<float>(M_PI) * static_cast<float>(k) / 40, radius = z < 0.3f ? 0.3f : 0.2f;
      const Vec3f out(std::cos(angle), std::sin(angle), 0);
      add_disc(scene.cloud, radius * out + Vec3f(0, 0, z), out, 0.02f, Vec3f::Ones());
      scene.truth.push_back(300);
    }
  for (float x = -1; x <= 1; x += 0.03f)
    for (float y = -1; y <= 1; y += 0.03f) {
      const Vec3f at(x, y, level);
      if (std::hypot(x, y) < 0.32f || !rest(at)) continue;
      add_disc(scene.cloud, at, Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
      scene.truth.push_back(3);
    }
  return scene;
}

TEST(Extract, NothingOfTheObjectGoesToARestThatDoesNotCarryIt) {
  const auto extracted = [](const MadeScene& scene, std::optional<std::vector<uint32_t>> supports = std::nullopt) {
    ExtractOptions options;
    options.object = 300;
    options.supports = std::move(supports);
    return extract(options, scene.cloud, certain(scene.truth, {3, 300}));
  };
  const auto everywhere = [](const Vec3f&) { return true; };
  const auto two_hands = [](const Vec3f& x) { return std::abs(x.y()) < 0.12f && std::abs(x.x()) < 0.7f; };
  const auto expect_none = [](const ExtractResult& result) {
    EXPECT_FALSE(result.contact.found);
    EXPECT_FALSE(result.summary.support.has_value());
    EXPECT_EQ(result.summary.contact_to_support, 0u);
  };
  const ExtractResult ground = extracted(figure(everywhere, 0));
  EXPECT_TRUE(ground.contact.found);
  EXPECT_EQ(ground.summary.support, 3u);
  expect_none(extracted(figure(two_hands, 0.02f)));                        // beside its foot, but no ground
  expect_none(extracted(figure(everywhere, 0.25f)));                       // a brim passes through it
  expect_none(extracted(figure(everywhere, 0), std::vector<uint32_t>{}));  // known to be no support
  EXPECT_EQ(extracted(figure(two_hands, 0.02f), std::vector<uint32_t>{3}).summary.support, 3u) << "known to be one";
}

TEST(Extract, ADensePartThatTouchesTheObjectIsNoFloater) {
  MadeScene scene = made_scene(two_balls(), 1);
  const MadeScene::Ball ball = scene.balls[0];
  for (int i = 0; i < 27; ++i) {  // its Gaussians have their nearest ones among themselves
    const Vec3f x = 0.005f * Vec3f(i % 3 - 1.0f, i / 3 % 3 - 1.0f, i / 9 - 1.0f);
    add_disc(scene.cloud, ball.centre + x + Vec3f(0, 0, ball.radius + 0.05f), Vec3f::UnitZ(), 0.004f, Vec3f::Ones());
    scene.truth.push_back(300);
  }
  ExtractOptions options;
  options.object = 300;
  options.floater_share = 0.1f;
  EXPECT_EQ(extract(options, scene.cloud, certain(scene.truth, kObjectIds)).summary.floaters, 0u);
}

TEST(Extract, AnUnknownIdIsAUsageErrorThatListsTheKnownOnes) {
  const MadeScene scene = made_scene(two_balls(), 1);
  ExtractOptions options;
  options.object = 12;
  expect_error(Failure::kUsage, {"12", "70000"},
               [&] { extract(options, scene.cloud, certain(scene.truth, kObjectIds)); });
}

TEST(Contact, PlaneOfATiltedNoisyTableIsFoundUnderTheObject) {
  const Vec3f normal = Vec3f(0.15f, -0.1f, 1.0f).normalized();
  const Mat3f frame = shortest_rotation<float>(Vec3f::UnitZ(), normal);
  Random random(4);
  GaussianCloud support, object;
  for (int i = 0; i < 3000; ++i) {
    Vec3f x(random.uniform(-1, 1), random.uniform(-1, 1), 0.002 * random.normal());
    if (i % 5 == 0) x.z() = static_cast<float>(random.uniform(-0.3, 0.3));  // clutter with the same label
    if (std::hypot(x.x(), x.y()) > 0.1) add_disc(support, frame * x, normal, 0.02f, Vec3f::Ones());
  }
  for (int i = 0; i < 2000; ++i) {
    const float angle = static_cast<float>(random.uniform(0, 2 * M_PI)), z = static_cast<float>(random.uniform(0, 0.6));
    add_disc(object, frame * Vec3f(0.12f * std::cos(angle), 0.12f * std::sin(angle), z), normal, 0.02f, Vec3f::Ones());
  }
  const ContactRegion region = contact_region(object.position, support.position, Vec3f::UnitZ());
  ASSERT_TRUE(region.found);
  EXPECT_GT(region.normal.dot(normal), std::cos(0.01f));
  EXPECT_LT(std::abs(normal.dot(region.point)), 0.003f);
  EXPECT_NEAR(region.band_low, 0.0f, 0.02f);
  EXPECT_NEAR(region.band_high, 0.04f * 0.6f, 0.015f);
  size_t touching = 0;
  for (const Vec3f& x : object.position) touching += region.in_band(x);
  EXPECT_EQ(touching, region.touching);
}

TEST(Contact, WithoutASupportNothingIsFound) {
  const MadeScene scene = made_scene(two_balls(), 1);
  EXPECT_FALSE(contact_region(scene.cloud.position, {}, Vec3f::UnitZ()).found);
}

}  // namespace
}  // namespace pliant
