#include "segmentation/discover/automatic_supports.h"

#include <gtest/gtest.h>

#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

SolidScene solid_of(const std::vector<Vec3f>& points) {
  SolidScene scene;
  for (const Vec3f& x : points) add_disc(scene.cloud, x, Vec3f::UnitZ(), 0.02f, Vec3f::Ones());
  scene.mass.assign(points.size(), 1.0f / static_cast<float>(points.size()));
  scene.graph.spacing = 0.02f;
  return scene;
}

TEST(FindSupports, AreThoseOfAnyOrderAndOriginAndNoSlabThroughABody) {
  // A wide low body, closed below and above, with a narrow neck; then the same on a ground.
  std::vector<Vec3f> body, ground;
  for (int i = 0; i < 20000; ++i) {
    Random random(7, i);
    const float angle = static_cast<float>(random.uniform(0, 2 * M_PI)), u = static_cast<float>(random.uniform());
    const int part = i % 4;  // floor, side, lid, neck
    const float radius = part == 1   ? 1.0f
                         : part == 3 ? 0.2f
                                     : std::sqrt(u),
                height = part == 0   ? 0.0f
                         : part == 1 ? 0.6f * u
                         : part == 2 ? 0.6f
                                     : 0.6f + 2 * u;
    body.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    ground.emplace_back(static_cast<float>(random.uniform(-3, 3)), static_cast<float>(random.uniform(-3, 3)), 0.0f);
  }
  ground.insert(ground.end(), body.begin(), body.end());
  const auto found = [](std::vector<Vec3f> points, uint64_t seed) {
    SupportOptions options;
    options.seed = seed;
    return find_supports(options, solid_of(points), Vec3f::UnitZ());
  };
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    EXPECT_TRUE(found(body, seed).empty()) << seed;
    const std::vector<Support> on = found(ground, seed);
    ASSERT_FALSE(on.empty()) << seed;
    EXPECT_LT(std::abs(on[0].height(Vec3f::Zero())), 0.03f);
    EXPECT_GT(on[0].normal.z(), 0.999f);
  }
  const std::vector<Support> given = found(ground, 1);
  std::vector<Vec3f> turned(ground.rbegin(), ground.rend()), moved = ground;
  for (Vec3f& x : moved) x += Vec3f(3, -2, 5);
  const std::vector<Support> reversed = found(turned, 1), shifted = found(moved, 1);
  ASSERT_EQ(given.size(), reversed.size());
  ASSERT_EQ(given.size(), shifted.size());
  for (size_t k = 0; k < given.size(); ++k) {
    EXPECT_EQ(given[k].point, reversed[k].point);
    EXPECT_EQ(given[k].share, reversed[k].share);
    EXPECT_LT((given[k].point + Vec3f(3, -2, 5) - shifted[k].point).norm(), 0.02f);
    EXPECT_GT(given[k].normal.dot(shifted[k].normal), 0.9999f);
  }
}

// A ground with a small thing on it and a haze below: more than a tenth of what is beside the ground lies below it, but
// less than a tenth of the ground.
TEST(FindSupports, AreTheGroundThatHoldsNearlyEverythingThoughHazeLiesBelow) {
  const auto found = [](int haze) {
    std::vector<Vec3f> points;
    for (int i = 0; i < 20000; ++i) {
      Random random(5, i);
      const auto between = [&](float a, float b) { return static_cast<float>(random.uniform(a, b)); };
      if (i < 1000)
        points.emplace_back(between(-0.3f, 0.3f), between(-0.3f, 0.3f), between(0.1f, 1));
      else if (i < 1000 + haze)
        points.emplace_back(between(-3, 3), between(-3, 3), between(-1.5f, -0.2f));
      else
        points.emplace_back(between(-3, 3), between(-3, 3), 0.0f);
    }
    return find_supports(SupportOptions(), solid_of(points), Vec3f::UnitZ());
  };
  const std::vector<Support> ground = found(1000);
  ASSERT_EQ(ground.size(), 1u);
  EXPECT_LT(std::abs(ground[0].height(Vec3f::Zero())), 0.03f);
  EXPECT_GT(ground[0].normal.z(), 0.999f);
  EXPECT_TRUE(found(5000).empty()) << "as much as a third of it";
}

/// Points spread over a parallelogram.
void add_sheet(const Vec3f& corner, const Vec3f& a, const Vec3f& b, int count, std::vector<Vec3f>& points) {
  for (int i = 0; i < count; ++i) {
    Random random(3, points.size());
    const float s = static_cast<float>(random.uniform()), t = static_cast<float>(random.uniform());
    points.push_back(corner + s * a + t * b + Vec3f::Constant(0.002f * static_cast<float>(random.normal())));
  }
}

TEST(PlanesBehind, AreThoseWideOnesClearOfTheThingWithNothingBeyond) {
  std::vector<Vec3f> wall, all;
  add_sheet(Vec3f(-2, -2, 0), Vec3f(4, 0, 0), Vec3f(0, 4, 0), 6000, wall);  // z = 0
  all = wall;
  add_sheet(Vec3f(-0.2f, -0.2f, 0.5f), Vec3f(0.4f, 0, 0), Vec3f(0, 0.4f, 0), 150, all);  // a small plate before it
  const auto behind = [](const std::vector<Vec3f>& points, const Vec3f& thing) {
    return planes_behind({}, points, thing, 5, 0.01f);
  };
  const std::vector<Support> found = behind(all, Vec3f(0, 0, 0.6f));
  ASSERT_EQ(found.size(), 1u) << "the plate is no wall";
  EXPECT_GT(found[0].normal.z(), 0.999f);
  EXPECT_NEAR(found[0].height(Vec3f(0, 0, 0.6f)), 0.6, 0.01);
  EXPECT_TRUE(behind(all, Vec3f(0, 0, 0.01f)).empty()) << "what was marked lies in the plane";
  EXPECT_EQ(behind(all, Vec3f(0, 0, -0.6f)).size(), 1u) << "the side does not matter ...";
  std::vector<Vec3f> two = all;
  add_sheet(Vec3f(-2, -2, -0.5f), Vec3f(4, 0, 0), Vec3f(0, 4, 0), 3000, two);
  const std::vector<Support> last = behind(two, Vec3f(0, 0, 0.8f));
  ASSERT_EQ(last.size(), 1u);
  EXPECT_NEAR(last[0].height(Vec3f(0, 0, 0.8f)), 1.3, 0.01) << "... but one through which more is seen is no wall";
  EXPECT_TRUE(behind({}, Vec3f::Zero()).empty());
}

TEST(PlanesNearby, FindATableThatIsSmallInTheScene) {
  std::vector<Vec3f> points;
  add_sheet(Vec3f(-9, -9, -1), Vec3f(18, 0, 0), Vec3f(0, 18, 0), 20000, points);
  add_sheet(Vec3f(-0.7f, -0.7f, 0), Vec3f(1.4f, 0, 0), Vec3f(0, 1.4f, 0), 3000, points);
  const Vec3f thing(0, 0, 0.3f);  // nearer to the table than two tolerances in a scene of this size
  const std::vector<float> shown(points.size(), 1.0f), apart(points.size(), 0.01f);
  const std::vector<Support> wide = planes_behind({}, draw_points(points, shown, 1), thing, 25, 0.01f);
  ASSERT_EQ(wide.size(), 1u) << "the floor alone";
  EXPECT_NEAR(wide[0].height(thing), 1.3, 0.02);
  const std::vector<Support> nearby = planes_nearby({}, {points, shown, apart}, thing, 25, wide);
  ASSERT_EQ(nearby.size(), 1u) << "the table, once, and the floor no second time";
  EXPECT_NEAR(nearby[0].height(thing), 0.3, 0.01);
  EXPECT_GT(nearby[0].normal.z(), 0.99f);
}

TEST(ShareBeyond, IsOneOnATableHalfBeforeABackAndNoneWithinTheThing) {
  Support plane;  // z = 0
  plane.tolerance = 0.02f;
  const auto share = [&](const Vec3f& corner, const Vec3f& a, const Vec3f& b) {
    std::vector<Vec3f> points;
    add_sheet(Vec3f(-0.1f, -0.3f, 0.05f), Vec3f(0.2f, 0, 0), Vec3f(0, 0.6f, 0), 500, points);  // of the thing
    add_sheet(Vec3f(-0.1f, -0.3f, 0.05f), Vec3f(0, 0.6f, 0), Vec3f(0, 0, 0.5f), 500, points);
    add_sheet(Vec3f(0.1f, -0.3f, 0.05f), Vec3f(0, 0.6f, 0), Vec3f(0, 0, 0.5f), 500, points);
    std::vector<uint8_t> label(points.size(), 1);
    add_sheet(corner, a, b, 4000, points);
    label.resize(points.size(), 0);
    return share_beyond(plane, points, label);
  };
  EXPECT_EQ(share(Vec3f(-1, -1, 0), Vec3f(2, 0, 0), Vec3f(0, 2, 0)), 1);
  EXPECT_NEAR(share(Vec3f(0, -1, 0), Vec3f(1, 0, 0), Vec3f(0, 2, 0)), 0.5, 0.09);
  EXPECT_EQ(share(Vec3f(-0.1f, -0.3f, 0), Vec3f(0.2f, 0, 0), Vec3f(0, 0.6f, 0)), 0);
  EXPECT_EQ(share_beyond(plane, std::vector<Vec3f>(3, Vec3f::Zero()), std::vector<uint8_t>(3, 0)), 0) << "no thing";
}

}  // namespace
}  // namespace pliant
