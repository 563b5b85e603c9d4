// The contact shadow of a removed object: its gain is measured, it goes when it is plain and is asked to, and paint
// stays.

#include "segmentation/repair/shadow.h"

#include <gtest/gtest.h>

#include "segmentation/repair/repair.h"
#include "tests/segmentation/repair/contact_shadow.h"

namespace pliant {
namespace {

struct Stained {
  GaussianCloud background, object, clean;  ///< clean: the background before `gain`
  std::vector<Camera> cameras;
};
template <class Gain>
Stained stained(Gain gain) {
  MadeScene scene = made_scene(two_balls(), 8, 200, 150);
  std::vector<int> object, background;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    (scene.truth[p] == 300 ? object : background).push_back(static_cast<int>(p));
  Stained out{scene.cloud.select(background), scene.cloud.select(object), scene.cloud.select(background),
              scene.cameras};
  shade_table(out.background, gain);
  return out;
}

float color(const GaussianCloud& cloud, size_t p, int k) { return 0.5f + kSh0 * cloud.sh_of(p)[k]; }

/// Index in the given background of every kept Gaussian.
std::vector<int> kept(const Stained& scene, const RepairResult& result) {
  std::vector<int> rest;
  for (size_t p = 0, next = 0; p < scene.background.size(); ++p)
    if (next < result.replaced.size() && result.replaced[next] == static_cast<int>(p))
      ++next;
    else
      rest.push_back(static_cast<int>(p));
  EXPECT_EQ(rest.size(), result.first_new);
  return rest;
}

size_t colors_changed(const Stained& scene, const RepairResult& result) {
  const GaussianCloud before = scene.background.select(kept(scene, result));
  size_t changed = 0;
  for (size_t p = 0; p < before.size(); ++p) {
    EXPECT_EQ(result.background.position[p], before.position[p]);
    EXPECT_EQ(result.background.opacity_logit[p], before.opacity_logit[p]);
    bool same = true;
    for (int k = 0; k < 3; ++k) same = same && result.background.sh_of(p)[k] == before.sh_of(p)[k];
    changed += !same;
  }
  return changed;
}

TEST(Shadow, ASoftContactShadowIsLiftedWithinFourPerCent) {
  const Stained scene = stained([](const Vec3f& x) { return Vec3f::Constant(soft_gain(x)).eval(); });
  const RepairResult result = repair({}, scene.background, scene.object, scene.cameras);
  EXPECT_EQ(result.summary.shadow, Shadow::Verdict::kPlain) << result.summary.shadow_doubt;
  EXPECT_TRUE(result.summary.shadow_lifted);
  EXPECT_NEAR(result.summary.shadow_darkest, 0.5, 0.12);
  EXPECT_NE(result.summary.describe_shadow().find("removed"), std::string::npos);
  double error = 0, shadow = 0;
  size_t count = 0;
  const GaussianCloud before = scene.background.select(kept(scene, result));
  for (size_t p = 0; p < before.size(); ++p) {
    const Vec3f& x = before.position[p];
    const float gain = soft_gain(x), recovered = color(before, p, 0) / color(result.background, p, 0);
    if (std::abs(x.z()) > 1e-4f || gain > 0.97f || (x - kFoot).norm() < kFootRadius + 0.03f) continue;
    error += std::abs(recovered - gain);
    shadow += 1 - gain;
    ++count;
  }
  ASSERT_GT(count, 50u);
  EXPECT_LT(error, 0.04 * static_cast<double>(count));
  EXPECT_GT(shadow, 0.15 * static_cast<double>(count));
  // The new Gaussians are lit like the rest of the table: no dark stain where the ball stood.
  double light = 0;
  size_t plain = 0;
  for (size_t p = result.first_new; p < result.background.size(); ++p) {
    const Vec3f& x = result.background.position[p];
    const float phase = x.x() / 0.25f - std::floor(x.x() / 0.25f);
    if (phase > 0.3f && phase < 0.8f) {
      light += color(result.background, p, 0);
      ++plain;
    }
  }
  EXPECT_NEAR(light / static_cast<double>(plain), 0.7, 0.06);
}

TEST(Shadow, IsKeptOnRequestAndReported) {
  const Stained scene = stained([](const Vec3f& x) { return Vec3f::Constant(soft_gain(x)).eval(); });
  RepairOptions options;
  options.repair_shadow = false;
  const RepairResult result = repair(options, scene.background, scene.object, scene.cameras);
  EXPECT_EQ(result.summary.shadow, Shadow::Verdict::kPlain);
  EXPECT_FALSE(result.summary.shadow_lifted);
  EXPECT_EQ(colors_changed(scene, result), 0u);
  EXPECT_NE(result.summary.describe_shadow().find("kept"), std::string::npos);
}

TEST(Shadow, ASpotOfPaintBesideTheObjectIsLeftAlone) {
  const Stained scene = stained([](const Vec3f& x) {
    return Vec3f::Constant((x - Vec3f(-0.35f, 0.56f, 0)).norm() < 0.09f ? 0.5f : 1.0f).eval();
  });
  const RepairResult result = repair({}, scene.background, scene.object, scene.cameras);
  EXPECT_EQ(result.summary.shadow, Shadow::Verdict::kNone);
  EXPECT_EQ(colors_changed(scene, result), 0u);
}

TEST(Shadow, WithoutOneNothingIsFound) {
  const Stained scene = stained([](const Vec3f&) { return Vec3f(1, 1, 1); });
  const RepairResult result = repair({}, scene.background, scene.object, scene.cameras);
  EXPECT_EQ(result.summary.shadow, Shadow::Verdict::kNone);
  EXPECT_EQ(colors_changed(scene, result), 0u);
  EXPECT_TRUE(result.summary.describe_shadow().empty());
}

TEST(Shadow, AStainOfAnotherHueUnderTheObjectIsLeftAndReported) {
  const Stained scene = stained([](const Vec3f& x) { return Vec3f(1, soft_gain(x), soft_gain(x)); });
  const RepairResult result = repair({}, scene.background, scene.object, scene.cameras);
  EXPECT_EQ(result.summary.shadow, Shadow::Verdict::kDoubtful);
  EXPECT_EQ(colors_changed(scene, result), 0u);
  EXPECT_NE(result.summary.describe_shadow().find("hue"), std::string::npos);
}

}  // namespace
}  // namespace pliant
