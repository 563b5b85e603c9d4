// The hole that a removed object leaves: what it is, that it closes, that it continues the pattern, and that nothing
// else changes.

#include "segmentation/repair/repair.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <cstdlib>
#include <numeric>

#include "gaussians/io/images/image_io.h"
#include "gaussians/render/blend_weights.h"
#include "segmentation/repair/patch.h"
#include "segmentation/repair/surfaces.h"
#include "segmentation/repair/visible.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

struct Parts {
  GaussianCloud background, object;
};

Parts without(const MadeScene& scene, uint32_t id) {
  std::vector<int> object, background;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    (scene.truth[p] == id ? object : background).push_back(static_cast<int>(p));
  return {scene.cloud.select(background), scene.cloud.select(object)};
}

/// The background without what the repair replaced, which must come back bit for bit.
GaussianCloud kept(const GaussianCloud& background, const RepairResult& result) {
  std::vector<int> rest;
  for (size_t p = 0, next = 0; p < background.size(); ++p)
    if (next < result.replaced.size() && result.replaced[next] == static_cast<int>(p))
      ++next;
    else
      rest.push_back(static_cast<int>(p));
  EXPECT_EQ(rest.size(), result.first_new);
  return background.select(rest);
}

void expect_equal(const GaussianCloud& a, const GaussianCloud& b, size_t count) {
  ASSERT_TRUE(a.size() >= count && b.size() >= count);
  for (size_t p = 0; p < count; ++p) {
    ASSERT_EQ(a.position[p], b.position[p]);
    ASSERT_EQ(a.rotation[p], b.rotation[p]);
    ASSERT_EQ(a.log_scale[p], b.log_scale[p]);
    ASSERT_EQ(a.opacity_logit[p], b.opacity_logit[p]);
    for (int k = 0; k < 3; ++k) ASSERT_EQ(a.sh_of(p)[k], b.sh_of(p)[k]);
  }
}

/// Writes the sheet for looking at when PLIANT_TEST_SHEETS names a folder.
void show(const RepairResult& result, const Parts& parts, const std::vector<Camera>& cameras, const std::string& name) {
  if (const char* folder = std::getenv("PLIANT_TEST_SHEETS"))
    write_image(std::filesystem::path(folder) / ("repair_" + name + ".png"),
                repair_sheet(result, parts.background, parts.object, cameras));
}

float luminance(const float* rgb) { return 0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2]; }

TEST(Hole, LiesWhereTheObjectWasAndTheTableIsMissing) {
  MadeScene scene = made_scene(two_balls(), 4);
  for (int v = 0; v < 4; ++v)  // from above, so that the ball is seen against the table
    scene.cameras[v] = look_at({v % 2 ? 1.2 : -1.2, v / 2 ? 1.2 : -1.2, 2.2}, {0, 0, 0.1}, {0, 0, 1}, 120, 90, 108);
  const Parts parts = without(scene, 300);
  const HoleOptions options;
  const Observation seen = observe(options, parts.background, parts.object, scene.cameras, {0, 1, 2, 3});
  for (size_t v = 0; v < 4; ++v) {
    const HoleView view = find_hole(options, seen, v, parts.background, scene.cameras);
    EXPECT_GT(view.pixels, 30u);
    const Vec3d eye = scene.cameras[v].centre();
    for (int y = 0; y < view.hole.height; ++y)
      for (int x = 0; x < view.hole.width; ++x) {
        if (!view.hole(x, y)) continue;
        EXPECT_GE(seen.object[v](x, y), options.min_object);
        const Vec3d ray = scene.cameras[v].ray(x + 0.5, y + 0.5);
        const Vec3d hit = eye - eye.z() / ray.z() * ray;
        EXPECT_LT((hit.cast<float>() - Vec3f(-0.35f, 0.1f, 0)).norm(), 0.3f);
      }
  }
}

TEST(Hole, GaussiansThatNobodyObservedAreAHoleEvenWhereTheyAreOpaque) {
  MadeScene scene = made_scene(two_balls(), 4);
  // Junk inside the first ball, wide enough to hide what is below it.
  for (int i = 0; i < 200; ++i) {
    Random random(3, i);
    add_disc(scene.cloud,
             Vec3f(-0.35f, 0.1f, 0.05f) +
                 Vec3f(0.1 * random.normal(), 0.1 * random.normal(), 0).cwiseMax(-0.16f).cwiseMin(0.16f),
             Vec3f::UnitZ(), 0.03f, Vec3f(0, 1, 0));
    scene.truth.push_back(MadeScene::kTable);
  }
  const Parts parts = without(scene, 300);
  const HoleOptions options;
  const Observation seen = observe(options, parts.background, parts.object, scene.cameras, {0, 1, 2, 3});
  const HoleView view = find_hole(options, seen, 1, parts.background, scene.cameras);
  size_t opaque = 0;
  for (size_t i = 0; i < view.hole.data.size(); ++i) opaque += view.hole.data[i] && view.picture.alpha.data[i] > 0.95f;
  EXPECT_GT(opaque, 50u);
}

// Far from the origin, with as many cameras that look away.
TEST(Surfaces, FaceTheCamerasThatSeeTheHole) {
  MadeScene scene = made_scene(two_balls(), 4);
  for (int v = 0; v < 4; ++v) {
    Camera away = scene.cameras[v];
    away.cam_from_world = Eigen::AngleAxisd(M_PI, Vec3d::UnitX()) * away.cam_from_world;
    scene.cameras.push_back(away);
  }
  const Vec3d move(0, 0, 20);
  for (Vec3f& x : scene.cloud.position) x += move.cast<float>();
  for (Camera& camera : scene.cameras) camera.cam_from_world.translate(-move);
  const Parts parts = without(scene, 300);
  const Observation seen = observe({}, parts.background, parts.object, scene.cameras, {0, 1, 2, 3, 4, 5, 6, 7});
  std::vector<HoleView> views;
  for (size_t v = 0; v < 8; ++v) views.push_back(find_hole({}, seen, v, parts.background, scene.cameras));
  EXPECT_GT(views[0].pixels, 0u);
  EXPECT_EQ(views[4].pixels, 0u);
  const Surfaces surfaces = find_surfaces(views, seen, parts.background, scene.cameras, 14, 1);
  ASSERT_EQ(surfaces.plane.size(), 1u);
  EXPECT_GT(surfaces.plane[0].plane.normal.z(), 0.99f);
}

// A wall whose middle consists of dots much smaller than a pixel, which the low-pass filter alone makes opaque.
TEST(Repair, FindsTheHolesOfTheScenesRasteriser) {
  Camera camera = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 41, 41, 100);
  GaussianCloud wall, object;
  for (int i = -24; i <= 24; ++i)
    for (int j = -24; j <= 24; ++j) {
      const bool dot = std::max(std::abs(i), std::abs(j)) <= 6;  // one a pixel
      add_disc(wall, Vec3f(0.02f * i, 0.02f * j, 0), Vec3f::UnitZ(), dot ? 0.002f : 0.02f, Vec3f(0.5f, 0.5f, 0.5f));
    }
  add_disc(object, Vec3f(0, 0, 0.5f), Vec3f::UnitZ(), 0.12f, Vec3f(1, 0, 0));
  RepairOptions options;
  options.hole.min_observed = options.hole.min_share = 0;
  EXPECT_EQ(repair(options, wall, object, {camera}).summary.before(), 0u);
  options.render.antialiased = true;
  EXPECT_GT(repair(options, wall, object, {camera}).summary.before(), 20u);
}

// What lies inside the ball shines through it a little, and is a guess all the same: it is replaced.
TEST(Repair, TakesOutWhatOnlyShoneThroughTheObject) {
  const MadeScene scene = made_scene(two_balls(), 10, 240, 180);
  Parts parts = without(scene, 300);
  for (float& logit : parts.object.opacity_logit) logit = 0;
  const Vec3f ball(-0.35f, 0.1f, 0.05f);
  const size_t whole = parts.background.size();
  for (int k = 0; k < 40; ++k)
    add_disc(parts.background, ball + 0.002f * static_cast<float>(k) * Vec3f::UnitZ(), Vec3f::UnitZ(), 0.03f,
             Vec3f(1, 0, 1));
  RepairOptions options;
  const auto replaced = [&] {
    size_t count = 0;
    for (const int p : repair(options, parts.background, parts.object, scene.cameras).replaced)
      count += static_cast<size_t>(p) >= whole;
    return count;
  };
  EXPECT_EQ(replaced(), 40u);
  options.hole.min_share = 0;
  EXPECT_LT(replaced(), 40u) << "some of it was seen in more than a twentieth of a pixel";
}

// The plane of the table goes on under the ball; nothing is put where views see the table itself beside the ball.
TEST(Repair, NewGaussiansOfAHoleDoNotLieOnWhatIsWhole) {
  MadeScene scene = made_scene(two_balls(), 10, 240, 180);
  const Parts parts = without(scene, 300);
  std::vector<int> views(scene.cameras.size());
  std::iota(views.begin(), views.end(), 0);
  const Observation seen = observe({}, parts.background, parts.object, scene.cameras, views);
  std::vector<HoleView> holes;
  for (size_t v = 0; v < views.size(); ++v) holes.push_back(find_hole({}, seen, v, parts.background, scene.cameras));
  GaussianCloud patch;
  const Vec3f ball(-0.35f, 0.1f, 0), beside(0.1f, -0.55f, 0);
  for (const Vec3f& x : {ball, beside}) add_disc(patch, x, Vec3f::UnitZ(), 0.02f, Vec3f(0, 0, 0));
  const GaussianCloud inside = inside_holes(patch, holes, seen, scene.cameras);
  ASSERT_EQ(inside.size(), 1u);
  EXPECT_EQ(inside.position[0], ball);
}

TEST(Repair, ClosesTheHoleWithoutTouchingTheBackground) {
  const MadeScene scene = made_scene(two_balls(), 10, 240, 180);
  const Parts parts = without(scene, 300);
  const RepairResult result = repair({}, parts.background, parts.object, scene.cameras);
  ASSERT_GT(result.background.size(), parts.background.size());
  expect_equal(result.background, kept(parts.background, result), result.first_new);
  // What was replaced lies where the ball met the table, which nobody could see.
  for (const int p : result.replaced) EXPECT_LT((parts.background.position[p] - Vec3f(-0.35f, 0.1f, 0)).norm(), 0.27f);
  EXPECT_GT(result.summary.before(), 1000u);
  EXPECT_LT(result.summary.after(), result.summary.before() / 200);
  EXPECT_LT(result.summary.outside_change, 1e-3f);

  // The planks go on: the whole table is known.
  const GaussianCloud whole = made_scene({}).cloud;
  double error = 0, spread = 0;
  for (int v : {0, 3, 6, 9}) {
    const std::vector<Camera> alone = {scene.cameras[v]};
    const Observation seen = observe({}, parts.background, parts.object, alone, {0});
    const HoleView before = find_hole({}, seen, 0, parts.background, alone);
    const ImageF after = render(result.background, scene.cameras[v]).color,
                 truth = render(whole, scene.cameras[v]).color;
    for (size_t i = 0; i < truth.pixels(); ++i) {
      if (!before.hole.data[i]) continue;
      error += std::abs(luminance(after.data.data() + 3 * i) - luminance(truth.data.data() + 3 * i));
      spread += std::abs(0.47f - luminance(truth.data.data() + 3 * i));
    }
  }
  EXPECT_LT(error, 0.5 * spread) << spread;  // a plain fill would reach the spread
  show(result, parts, scene.cameras, "ball");
}

TEST(Repair, NewGaussiansLieOnTheContinuedPlane) {
  const MadeScene scene = made_scene(two_balls(), 8, 160, 120);
  const Parts parts = without(scene, 300);
  const RepairResult result = repair({}, parts.background, parts.object, scene.cameras);
  ASSERT_GT(result.summary.plane_gaussians, 100u);
  for (size_t p = result.first_new; p < result.first_new + result.summary.plane_gaussians; ++p) {
    EXPECT_LT(std::abs(result.background.position[p].z()), 0.002f);
    EXPECT_LT((result.background.position[p] - Vec3f(-0.35f, 0.1f, 0)).norm(), 0.35f);
    EXPECT_GT(std::abs(rotation_matrix(result.background.rotation[p])(2, 2)), 0.999f);
  }
}

TEST(Repair, WhatNobodySawInTheHoleIsReplacedAndNothingElseThatNobodySaw) {
  const MadeScene scene = made_scene(two_balls(), 8, 160, 120);
  Parts parts = without(scene, 300);
  const size_t seen = parts.background.size();
  for (float x = -0.1f; x <= 0.1f; x += 0.03f)
    for (float y = -0.1f; y <= 0.1f; y += 0.03f)
      add_disc(parts.background, Vec3f(-0.35f + x, 0.1f + y, 0.05f), Vec3f::UnitZ(), 0.02f,
               Vec3f(0, 1, 0));  // inside the ball
  const size_t inside = parts.background.size();
  for (int i = 0; i < 30; ++i)  // behind the table
    add_disc(parts.background, Vec3f(0.02f * static_cast<float>(i), -0.5f, -0.05f), Vec3f::UnitZ(), 0.01f,
             Vec3f(0, 1, 0));
  const RepairResult result = repair({}, parts.background, parts.object, scene.cameras);
  size_t junk = 0;
  for (const int p : result.replaced) {
    junk += static_cast<size_t>(p) >= seen && static_cast<size_t>(p) < inside;
    EXPECT_LT(static_cast<size_t>(p), inside);
  }
  EXPECT_EQ(junk, inside - seen);
  expect_equal(result.background, kept(parts.background, result), result.first_new);
  for (const Camera& camera : scene.cameras) {
    const ImageF picture = render(result.background, camera).color;
    for (size_t i = 0; i < picture.pixels(); ++i)
      ASSERT_LT(picture.data[3 * i + 1], 0.1f + picture.data[3 * i] + picture.data[3 * i + 2]);
  }
}

// What is inside the ball is seen from below alone, by a camera that the repair does not look through.
TEST(Repair, WhatAnyCameraSawIsNotReplaced) {
  MadeScene scene = made_scene(two_balls(), 8, 160, 120);
  scene.cameras.push_back(look_at({3, 0.1, -6}, {-0.35, 0.1, 0.05}, {0, 0, 1}, 160, 120, 600));
  Parts parts = without(scene, 300);
  const size_t seen = parts.background.size();
  for (float x = -0.1f; x <= 0.1f; x += 0.03f)
    for (float y = -0.1f; y <= 0.1f; y += 0.03f)
      add_disc(parts.background, Vec3f(-0.35f + x, 0.1f + y, 0.05f), Vec3f::UnitZ(), 0.02f, Vec3f(0, 1, 0));
  RepairOptions options;
  options.max_views = 8;
  const RepairResult result = repair(options, parts.background, parts.object, scene.cameras);
  EXPECT_EQ(std::count(result.summary.views.begin(), result.summary.views.end(), 8), 0);
  GaussianCloud whole = parts.background;
  whole.append(parts.object);
  std::vector<double> most(whole.size(), 0.0);
  for (const Camera& camera : scene.cameras) {
    const BlendWeights W = blend_weights(whole, camera);
    std::vector<double> here(whole.size(), 0.0);
    for (size_t e = 0; e < W.weight.size(); ++e) here[W.gaussian[e]] += W.weight[e];
    for (size_t p = 0; p < here.size(); ++p) most[p] = std::max(most[p], here[p]);
  }
  for (const int p : result.replaced) EXPECT_LT(most[p], options.hole.min_observed) << p;
  size_t inside = 0;
  for (size_t p = seen; p < parts.background.size(); ++p) inside += most[p] >= options.hole.min_observed;
  EXPECT_GT(inside, 10u);
}

TEST(Repair, WithoutAHoleNothingIsAddedOrChanged) {
  MadeScene scene = made_scene({}, 8, 160, 120);  // the whole table, and a ball that floats above it
  GaussianCloud ball;
  for (int i = 0; i < 300; ++i) {
    const float z = 1 - (2 * i + 1.0f) / 300, r = std::sqrt(1 - z * z), a = 2.399963f * i;
    const Vec3f n(r * std::cos(a), r * std::sin(a), z);
    add_disc(ball, Vec3f(0, 0, 0.4f) + 0.1f * n, n, 0.02f, Vec3f(0.9f, 0.1f, 0.1f));
  }
  const RepairResult result = repair({}, scene.cloud, ball, scene.cameras);
  EXPECT_EQ(result.background.size(), scene.cloud.size());
  EXPECT_EQ(result.summary.before(), 0u);
  expect_equal(result.background, scene.cloud, scene.cloud.size());
}

TEST(Repair, TheOrderOfTheViewsDoesNotMatter) {
  MadeScene scene = made_scene(two_balls(), 8, 160, 120);
  const Parts parts = without(scene, 300);
  for (const int most : {24, 5}) {
    RepairOptions options;
    options.max_views = most;
    const RepairResult one = repair(options, parts.background, parts.object, scene.cameras);
    std::vector<Camera> shuffled;
    for (int v : {5, 2, 7, 0, 3, 6, 1, 4}) shuffled.push_back(scene.cameras[v]);
    const RepairResult two = repair(options, parts.background, parts.object, shuffled);
    ASSERT_EQ(one.background.size(), two.background.size());
    expect_equal(one.background, two.background, one.background.size());
  }
}

TEST(Repair, EqualBitForBitForAnyNumberOfThreads) {
  const MadeScene scene = made_scene(two_balls(), 4);
  const Parts parts = without(scene, 300);
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  const RepairResult one = repair({}, parts.background, parts.object, scene.cameras);
  omp_set_num_threads(3);
  const RepairResult three = repair({}, parts.background, parts.object, scene.cameras);
  omp_set_num_threads(threads);
  ASSERT_EQ(one.background.size(), three.background.size());
  EXPECT_EQ(one.background.sh, three.background.sh);
  for (size_t p = 0; p < one.background.size(); ++p)
    ASSERT_EQ(one.background.position[p], three.background.position[p]);
}

// One view sees the ball partly behind the other one, and beside it a pit in the table: what stands in front of the
// ball does not say that there is nothing behind it, and the table closes.
TEST(Repair, WhatStandsInFrontOfTheObjectDoesNotDecideWhatIsBehind) {
  MadeScene scene = made_scene(two_balls(), 10, 240, 180);
  scene.cameras.push_back(look_at({1.35, -0.9, 0.85}, {-0.2, 0.05, 0.1}, {0, 0, 1}, 240, 180, 260));
  const Vec3f pit(-0.49f, -0.13f, 0), ball(-0.35f, 0.1f, 0);
  Parts parts = without(scene, 300);
  std::vector<int> kept;
  for (size_t p = 0; p < parts.background.size(); ++p)
    if ((parts.background.position[p] - pit).norm() > 0.08f) kept.push_back(static_cast<int>(p));
  parts.background = parts.background.select(kept);
  const RepairResult result = repair({}, parts.background, parts.object, scene.cameras);
  const Camera above = look_at({-0.35, 0.1, 1.5}, {-0.35, 0.1, 0}, {0, 1, 0}, 120, 120, 300);
  const ImageF alpha = render(result.background, above).alpha;
  size_t open = 0, all = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 120; ++x) {
      const Vec3d ray = above.ray(x + 0.5, y + 0.5);
      const Vec3f at = (above.centre() - above.centre().z() / ray.z() * ray).cast<float>();
      if ((at - ball).norm() > 0.2f || (at - pit).norm() < 0.15f) continue;
      ++all;
      open += alpha(x, y) < 0.9f;
    }
  EXPECT_LT(static_cast<double>(open), 0.01 * static_cast<double>(all));
  show(result, parts, scene.cameras, "behind");
}

// Lines of the table that are transparent are seen through where the object was, and make the picture of the table no
// larger: its texels stay about as small as the pixels.
TEST(Repair, TransparentLinesMakeTheFillNoCoarser) {
  MadeScene scene = made_scene(two_balls(), 10, 240, 180);
  const Parts whole = without(scene, 300);
  Parts parts = whole;
  std::vector<int> kept;
  for (size_t p = 0; p < parts.background.size(); ++p) {
    const Vec3f& x = parts.background.position[p];
    if (std::abs(x.z()) > 0.01f || std::abs(std::remainder(x.y(), 0.3f)) > 0.02f) kept.push_back(static_cast<int>(p));
  }
  parts.background = parts.background.select(kept);
  const size_t before = repair({}, whole.background, whole.object, scene.cameras).summary.plane_gaussians;
  const size_t after = repair({}, parts.background, parts.object, scene.cameras).summary.plane_gaussians;
  EXPECT_GT(after, 0.8 * before);
}

TEST(Repair, ViewByViewFillingClosesTheHoleToo) {
  const MadeScene scene = made_scene(two_balls(), 6, 160, 120);
  const Parts parts = without(scene, 300);
  RepairOptions options;
  options.max_planes = 0;
  const RepairResult result = repair(options, parts.background, parts.object, scene.cameras);
  EXPECT_EQ(result.summary.plane_gaussians, 0u);
  EXPECT_LT(result.summary.after(), result.summary.before() / 20);
}

TEST(Repair, HoleAcrossACornerFollowsBothPlanes) {
  // Table z = 0 for y < 0 and a wall y = 0 for z > 0; a hole around the corner's middle.
  GaussianCloud cloud;
  for (float x = -1; x <= 1; x += 0.03f)
    for (float t = 0.015f; t <= 1; t += 0.03f) {
      if (std::hypot(x, t) < 0.2f) continue;
      add_disc(cloud, Vec3f(x, -t, 0), Vec3f::UnitZ(), 0.02f, Vec3f(0.6f, 0.4f, 0.2f));
      add_disc(cloud, Vec3f(x, 0, t), -Vec3f::UnitY(), 0.02f, Vec3f(0.2f, 0.4f, 0.6f));
    }
  GaussianCloud ball;
  for (int i = 0; i < 900; ++i) {
    const float z = 1 - (2 * i + 1.0f) / 900, r = std::sqrt(1 - z * z), a = 2.399963f * i;
    const Vec3f n(r * std::cos(a), r * std::sin(a), z);
    add_disc(ball, Vec3f(0, -0.2f, 0.2f) + 0.22f * n, n, 0.03f, Vec3f(0.9f, 0.1f, 0.1f));
  }
  std::vector<Camera> cameras;
  for (int v = 0; v < 4; ++v)
    cameras.push_back(look_at({-0.6 + 0.4 * v, -1.8, 0.9}, {0, -0.2, 0.2}, {0, 0, 1}, 160, 120, 150));
  const RepairResult result = repair({}, cloud, ball, cameras);
  EXPECT_EQ(result.summary.planes, 2u);
  EXPECT_EQ(result.summary.view_gaussians, 0u);
  EXPECT_LT(result.summary.after(), result.summary.before() / 50);
  show(result, {cloud, ball}, cameras, "corner");
  float worst = 0;
  for (size_t p = result.first_new; p < result.background.size(); ++p) {
    const Vec3f& x = result.background.position[p];
    worst = std::max({worst, std::min(std::abs(x.z()), std::abs(x.y())), -x.z(), x.y()});
  }
  EXPECT_LT(worst, 0.01f);
}

TEST(ExemplarFill, AStripePatternIsContinuedInPhase) {
  ImageF picture(96, 80, 3);
  ImageU8 known(96, 80, 1, 1), target(96, 80, 1);
  auto pattern = [](int x, int y) { return (x + y / 40) % 11 < 3 ? 0.2f : 0.8f; };
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 96; ++x) {
      const bool hole = std::hypot(x - 48, y - 40) < 17;
      target(x, y) = hole;
      known(x, y) = !hole;
      for (int k = 0; k < 3; ++k) picture(x, y, k) = hole ? 0.5f : pattern(x, y);
    }
  const ImageF filled = exemplar_fill({}, picture, known, target);
  size_t right = 0, count = 0;
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 96; ++x) {
      if (!target(x, y)) {
        EXPECT_EQ(filled(x, y), picture(x, y));
        continue;
      }
      ++count;
      right += std::abs(filled(x, y) - pattern(x, y)) < 0.15f;
    }
  EXPECT_GT(right, 0.93 * count);
}

TEST(ExemplarFill, WithoutAWholeSourcePatchTheSurroundingsAreSpread) {
  ImageF picture(12, 12, 3, 0.3f);
  ImageU8 known(12, 12, 1), target(12, 12, 1, 1);
  for (int x = 0; x < 12; ++x) {
    known(x, 0) = 1;
    target(x, 0) = 0;
  }
  for (size_t i = 0; i < target.data.size(); ++i)
    if (target.data[i]) std::fill_n(picture.data.data() + 3 * i, 3, 0.9f);
  const ImageF filled = exemplar_fill({}, picture, known, target);
  for (float value : filled.data) EXPECT_NEAR(value, 0.3f, 0.02f) << "steps of 1/255 add up across the hole";
}

}  // namespace
}  // namespace pliant
