#include "segmentation/discover/automatic.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <limits>

#include "segmentation/field/known_labels.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

AutomaticResult find_in(const MadeScene& scene) {
  AutomaticOptions options;
  return find_objects(options, scene.cloud, scene.cameras);
}

/// Intersection over union of the Gaussians of a truth id with the found object that fits best.
double best_iou(const MadeScene& scene, const AutomaticResult& result, uint32_t truth) {
  double best = 0;
  for (const FoundThing& thing : result.found) {
    if (thing.kind != FoundThing::Kind::kObject) continue;
    size_t both = 0, either = 0;
    for (size_t p = 0; p < scene.truth.size(); ++p) {
      const bool a = scene.truth[p] == truth, b = result.label[p] == thing.id;
      both += a && b;
      either += a || b;
    }
    best = std::max(best, static_cast<double>(both) / static_cast<double>(either));
  }
  return best;
}

std::vector<MadeScene::Ball> balls_on_a_circle(int count) {
  const Vec3f colours[] = {
      {0.8f, 0.1f, 0.1f}, {0.1f, 0.3f, 0.8f}, {0.2f, 0.7f, 0.2f}, {0.9f, 0.8f, 0.2f}, {0.8f, 0.8f, 0.8f}};
  std::vector<MadeScene::Ball> balls;
  for (int k = 0; k < count; ++k) {
    const float angle = 2 * static_cast<float>(M_PI) * k / count, radius = 0.14f + 0.02f * k;
    balls.push_back(
        {Vec3f(0.6f * std::cos(angle), 0.6f * std::sin(angle), 0.8f * radius), radius, 10u + k, colours[k]});
  }
  return balls;
}

TEST(Automatic, AsManyObjectsAsStandOnAPlaneAreFound) {
  for (int count : {1, 3, 5}) {
    const MadeScene scene = made_scene(balls_on_a_circle(count));
    const AutomaticResult result = find_in(scene);
    EXPECT_EQ(result.summary.objects, count);
    EXPECT_EQ(result.summary.supports, 1);
    for (const auto& ball : scene.balls) EXPECT_GT(best_iou(scene, result, ball.id), 0.8) << count << " objects";
  }
}

TEST(Automatic, ObjectsAreNumberedBySizeAndNamed) {
  const AutomaticResult result = find_in(made_scene(balls_on_a_circle(3)));
  ASSERT_EQ(result.found.size(), 5u);
  for (uint32_t k = 0; k < 3; ++k) EXPECT_EQ(result.found[k].name, "object_" + std::to_string(k + 1));
  EXPECT_GE(result.found[0].share, result.found[1].share);
  EXPECT_GE(result.found[1].share, result.found[2].share);
  EXPECT_EQ(result.found[3].name, "support_1");
  EXPECT_EQ(result.found[4].name, "rest");
  EXPECT_EQ(result.found[0].id, 1u);
}

TEST(Automatic, APlaneAloneHasNoObject) {
  const AutomaticResult result = find_in(made_scene({}));
  EXPECT_EQ(result.summary.objects, 0);
  EXPECT_EQ(result.summary.supports, 1);
}

TEST(Automatic, AWallIsASupportAndNoObject) {
  MadeScene scene = made_scene(two_balls());
  for (float x = -1; x <= 1; x += 0.03f)
    for (float z = 0.03f; z <= 0.9f; z += 0.03f)
      add_disc(scene.cloud, Vec3f(x, 1, z), -Vec3f::UnitY(), 0.018f, Vec3f(0.5f, 0.6f, 0.6f));
  std::erase_if(scene.cameras, [](const Camera& camera) { return camera.centre().y() > 0.5; });
  const AutomaticResult result = find_in(scene);
  EXPECT_EQ(result.summary.objects, 2);
  EXPECT_EQ(result.summary.supports, 2);
  EXPECT_EQ(result.found[result.label.back() - 1].name, "support_2");
}

TEST(Automatic, WhatFloatsIsNoObject) {
  MadeScene scene = made_scene(two_balls());
  for (int k = 0; k < 200; ++k)
    add_disc(scene.cloud, Vec3f(0.02f * (k % 14), 0.02f * (k / 14), 0.9f), Vec3f::UnitZ(), 0.015f,
             Vec3f(0.3f, 0.3f, 0.3f));
  const AutomaticResult result = find_in(scene);
  EXPECT_EQ(result.summary.objects, 2);
  EXPECT_EQ(result.found[result.label.back() - 1].kind, FoundThing::Kind::kRest);
}

TEST(Automatic, CrumbsBelongToWhatTheyLieAgainstAndInTheAirToNothing) {
  MadeScene scene = made_scene(two_balls());
  const size_t first = scene.cloud.size();
  for (const float height : {0.07f, 0.5f})
    for (int k = 0; k < 9; ++k)
      add_disc(scene.cloud, Vec3f(0.6f + 0.03f * (k % 3), 0.6f + 0.03f * (k / 3), height), Vec3f::UnitZ(), 0.018f,
               Vec3f(0.3f, 0.6f, 0.3f));
  const AutomaticResult result = find_in(scene);
  for (size_t p = first; p < first + 18; ++p)
    EXPECT_EQ(result.found[result.label[p] - 1].name, p < first + 9 ? "support_1" : "rest");
}

TEST(Automatic, ASplatOfOneThingAloneIsWhole) {
  // A ball without a table, and in the corners of its bounds crumbs that hang on nothing.
  const auto without_table = [](const Vec3f& shift) {
    MadeScene scene = made_scene({{Vec3f(0, 0, 0.6f), 0.4f, 10, Vec3f(0.8f, 0.6f, 0.2f)}});
    std::vector<int> ball;
    for (size_t p = 0; p < scene.cloud.size(); ++p)
      if (scene.truth[p] == 10) ball.push_back(static_cast<int>(p));
    scene.cloud = scene.cloud.select(ball);
    for (const float x : {-0.31f, 0.31f})
      for (const float y : {-0.31f, 0.31f})
        for (const float z : {0.29f, 0.91f})
          for (int k = 0; k < 27; ++k)
            add_disc(scene.cloud,
                     Vec3f(x + 0.065f * (k / 9 - 1) + 0.022f * (k % 3 - 1), y + 0.022f * (k / 3 % 3 - 1), z) + shift,
                     Vec3f::UnitZ(), 0.016f, Vec3f(0.3f, 0.6f, 0.3f));
    return find_in(scene);
  };
  const AutomaticResult within = without_table(Vec3f::Zero());
  EXPECT_EQ(within.summary.objects, 1);
  EXPECT_EQ(within.summary.rest, 0);
  for (const uint32_t id : within.label) EXPECT_EQ(id, 1u);
  const AutomaticResult outside = without_table(Vec3f(0, 0.3f, 0));
  EXPECT_GT(outside.summary.rest, 0.02) << "what lies elsewhere is not of it";
}

/// The Gaussians of a made scene's balls, without the table.
MadeScene without_table(const std::vector<MadeScene::Ball>& balls) {
  MadeScene scene = made_scene(balls);
  std::vector<int> kept;
  std::vector<uint32_t> truth;
  for (size_t p = 0; p < scene.cloud.size(); ++p)
    if (scene.truth[p] != MadeScene::kTable) {
      kept.push_back(static_cast<int>(p));
      truth.push_back(scene.truth[p]);
    }
  scene.cloud = scene.cloud.select(kept);
  scene.truth = truth;
  return scene;
}

TEST(Automatic, WhatLiesCloseToAThingAloneBelongsToItAndThingsApartStayApart) {
  // A nose that no edge joins to the ball, large enough to be an object, and a patch too small to be one.
  const MadeScene::Ball ball{Vec3f(0, 0, 0.6f), 0.4f, 10, Vec3f(0.8f, 0.6f, 0.2f)};
  MadeScene face = without_table({ball});
  const size_t whole = face.cloud.size();
  const auto add_clump = [&](const Vec3f& at, int side) {
    for (int i = 0; i < side * side; ++i)
      add_disc(face.cloud, at + 0.01f * Vec3f(static_cast<float>(i % side), 0, static_cast<float>(i / side)),
               Vec3f::UnitY(), 0.008f, Vec3f(0.3f, 0.6f, 0.3f));
  };
  add_clump(ball.centre + Vec3f(-0.05f, ball.radius + 0.09f, -0.05f), 8);
  add_clump(ball.centre + Vec3f(0, -ball.radius - 0.09f, 0), 3);
  ASSERT_GT(face.cloud.size(), whole);
  const AutomaticResult one = find_in(face);
  EXPECT_EQ(one.summary.objects, 1);
  EXPECT_EQ(one.summary.rest, 0);
  for (const uint32_t id : one.label) EXPECT_EQ(id, 1u);

  const MadeScene pair = without_table({{Vec3f(-0.5f, 0, 0.6f), 0.3f, 10, Vec3f(0.8f, 0.1f, 0.1f)},
                                        {Vec3f(0.5f, 0, 0.6f), 0.2f, 20, Vec3f(0.1f, 0.3f, 0.8f)}});
  const AutomaticResult two = find_in(pair);
  EXPECT_EQ(two.summary.objects, 2);
  for (const auto& each : pair.balls) EXPECT_GT(best_iou(pair, two, each.id), 0.95);
}

/// Two balls on the table that touch.
MadeScene touching_balls(const Vec3f& first, const Vec3f& second) {
  return made_scene({{Vec3f(-0.24f, 0, 0.2f), 0.25f, 10, first}, {Vec3f(0.22f, 0, 0.18f), 0.23f, 20, second}});
}

TEST(Automatic, ThingsThatTouchArePartedByColourAndAreOneWithoutADifference) {
  const MadeScene two = touching_balls({0.8f, 0.1f, 0.1f}, {0.1f, 0.3f, 0.8f});
  const AutomaticResult parted = find_in(two);
  EXPECT_EQ(parted.summary.objects, 2);
  for (const auto& ball : two.balls) EXPECT_GT(best_iou(two, parted, ball.id), 0.8);
  EXPECT_NE(parted.found[0].how.find("separated from"), std::string::npos);

  const AutomaticResult one = find_in(touching_balls({0.8f, 0.1f, 0.1f}, {0.8f, 0.1f, 0.1f}));
  EXPECT_EQ(one.summary.objects, 1);
  EXPECT_EQ(one.found[0].how.find("separated from"), std::string::npos);
}

TEST(Automatic, IdPicturesShowTheObjectsWhereTheyAre) {
  const MadeScene scene = made_scene(two_balls());
  AutomaticOptions options;
  options.held_out = {0, 4};
  const AutomaticResult result = find_objects(options, scene.cloud, scene.cameras);
  EXPECT_EQ(result.summary.views, static_cast<int>(scene.cameras.size()) - 2);
  const Segmentation segmentation = segmentation_of_labels(result.label, {}, scene.cloud, scene.cameras, 1);
  for (const int camera : options.held_out) {
    const IdImage truth = cast_ids(scene, scene.cameras[camera]);
    const IdImage shown = render_ids(segmentation, scene.cloud, scene.cameras[camera]);
    size_t both = 0, either = 0;
    for (size_t i = 0; i < truth.data.size(); ++i) {
      const bool a = truth.data[i] != 0 && truth.data[i] != MadeScene::kTable,
                 b = shown.data[i] == 1 || shown.data[i] == 2;
      both += a && b;
      either += a || b;
    }
    EXPECT_GT(static_cast<double>(both), 0.8 * static_cast<double>(either));
  }
}

TEST(Automatic, EqualForAnyNumberOfThreads) {
  const MadeScene scene = made_scene(two_balls());
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const AutomaticResult one = find_in(scene);
  omp_set_num_threads(3);
  const AutomaticResult three = find_in(scene);
  omp_set_num_threads(threads);
  EXPECT_EQ(one.label, three.label);
}

TEST(Automatic, HostileCloudsGiveNothing) {
  const MadeScene scene = made_scene(two_balls(), 3);
  AutomaticOptions options;
  EXPECT_EQ(find_objects(options, GaussianCloud{}, scene.cameras).summary.objects, 0);
  EXPECT_EQ(find_objects(options, scene.cloud, {}).summary.objects, 0);

  GaussianCloud one;
  add_disc(one, Vec3f::Zero(), Vec3f::UnitZ(), 0.1f, Vec3f::Constant(0.5f));
  EXPECT_EQ(find_objects(options, one, scene.cameras).summary.objects, 0);

  GaussianCloud broken = scene.cloud;
  for (float& logit : broken.opacity_logit) logit = std::numeric_limits<float>::quiet_NaN();
  const AutomaticResult result = find_objects(options, broken, scene.cameras);
  EXPECT_EQ(result.summary.objects, 0);
  EXPECT_EQ(result.label.size(), broken.size());

  GaussianCloud heap;  // all in one place
  for (int k = 0; k < 500; ++k) add_disc(heap, Vec3f::Zero(), Vec3f::UnitZ(), 0.1f, Vec3f::Constant(0.5f));
  EXPECT_EQ(find_objects(options, heap, scene.cameras).label.size(), heap.size());
}

TEST(Automatic, BrokenGaussiansAmongSoundOnesChangeNothing) {
  MadeScene scene = made_scene(two_balls());
  const AutomaticResult sound = find_in(scene);
  const size_t n = scene.cloud.size();
  for (int k = 0; k < 20; ++k) {
    add_disc(scene.cloud, Vec3f(0, 0, 0.3f), Vec3f::UnitZ(), 0.02f, Vec3f::Constant(0.5f));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    if (k % 3 == 0) scene.cloud.position.back().x() = nan;
    if (k % 3 == 1) scene.cloud.log_scale.back().y() = nan;
    if (k % 3 == 2) scene.cloud.sh_of(n + k)[1] = nan;
  }
  const AutomaticResult broken = find_in(scene);
  EXPECT_TRUE(std::equal(sound.label.begin(), sound.label.end(), broken.label.begin()));
}

/// A picture of a plane, with colour, normal and depth by pixel.
template <class Pixel>
SurfacePicture flat_picture(Pixel pixel) {
  SurfacePicture picture;
  picture.width = 60;
  picture.height = 40;
  picture.focal = 50;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      picture.alpha.push_back(1);
      picture.lab.push_back(Vec3f::Constant(0.5f));
      picture.normal.push_back(-Vec3f::UnitZ());
      float depth = 2;
      pixel(x, y, picture.lab.back(), picture.normal.back(), depth, picture.alpha.back());
      picture.point.push_back(depth * Vec3f((x - 30) / 50.0f, (y - 20) / 50.0f, 1));
    }
  return picture;
}

uint32_t segments_of(const SurfacePicture& picture) {
  const IdImage ids = picture_segments({}, picture);
  return *std::max_element(ids.data.begin(), ids.data.end());
}

TEST(PictureSegments, EdgesOfColourNormalAndDepthPartThePictureAndSlopesDoNot) {
  EXPECT_EQ(segments_of(flat_picture([](int, int, Vec3f&, Vec3f&, float&, float&) {})), 1u);
  EXPECT_EQ(
      segments_of(flat_picture([](int x, int, Vec3f& lab, Vec3f&, float&, float&) { lab[0] = x < 30 ? 0.3f : 0.6f; })),
      2u);
  EXPECT_EQ(segments_of(flat_picture([](int x, int, Vec3f&, Vec3f& normal, float&, float&) {
              if (x < 30) normal = Vec3f(1, 0, -1).normalized();
            })),
            2u);
  EXPECT_EQ(
      segments_of(flat_picture([](int x, int, Vec3f&, Vec3f&, float& depth, float&) { depth = x < 30 ? 2.0f : 3.0f; })),
      2u);
  // A plane seen at a slant: depth changes fast from pixel to pixel, but along its tangent.
  EXPECT_EQ(segments_of(flat_picture([](int x, int, Vec3f&, Vec3f& normal, float& depth, float&) {
              normal = Vec3f(-1, 0, -1).normalized();
              depth = 2 / (1 + (x - 30) / 50.0f);
            })),
            1u);
}

TEST(PictureSegments, WhatIsNotOpaqueStaysUnlabelled) {
  const SurfacePicture picture =
      flat_picture([](int x, int, Vec3f&, Vec3f&, float&, float& alpha) { alpha = x < 30 ? 1.0f : 0.2f; });
  const IdImage ids = picture_segments({}, picture);
  EXPECT_EQ(ids(10, 10), 1u);
  EXPECT_EQ(ids(40, 10), 0u);
}

}  // namespace
}  // namespace pliant
