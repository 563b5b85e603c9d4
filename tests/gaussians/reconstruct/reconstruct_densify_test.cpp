// Laws of densification: Gaussians that share a place look like the one they replace, budgets hold, what is broken
// goes.

#include <gtest/gtest.h>

#include <numeric>

#include "gaussians/reconstruct/densify_classic.h"
#include "gaussians/reconstruct/densify_mcmc.h"
#include "tests/gaussians/made_photos.h"

namespace pliant {
namespace {

TrainingState state_of(GaussianCloud cloud) {
  TrainingState state;
  state.started_with = cloud.size();
  state.cloud = std::move(cloud);
  fit_moments(state);
  return state;
}

double mean_square(const ImageF& a, const ImageF& b) { return mse_loss(a, b); }

TEST(Mcmc, CopiesInOnePlaceHaveTheOpacityAndTheIntegralOfTheOne) {
  for (const double opacity : {0.01, 0.3, 0.9, 0.99}) {
    for (const int copies : {1, 2, 3, 7, 20}) {
      const SharedOpacity shared = share_opacity(opacity, copies);
      EXPECT_NEAR(1 - std::pow(1 - shared.opacity, copies), opacity, 1e-12);
      // Integral over a line through the centre of what n copies blend to, for a standard deviation of 1.
      double sum = 0;
      const double step = 1e-3;
      for (double x = -12; x < 12; x += step)
        sum += step * (1 - std::pow(1 - shared.opacity * std::exp(-0.5 * std::pow(x / shared.scale, 2)), copies));
      EXPECT_NEAR(sum, opacity * std::sqrt(2 * 3.141592653589793), 2e-4 * opacity) << opacity << " " << copies;
    }
  }
}

TEST(Mcmc, RelocationFillsTheBudgetAndKeepsThePicture) {
  TrainOptions options;
  TrainingState state = state_of(painted_ball(600, 1));
  for (size_t i = 0; i < 60; ++i) state.cloud.opacity_logit[i * 10] = -8;  // dead
  state.cloud.position[5].x() = NAN;
  const Camera camera = photos_of(state.cloud, 1, 96, 72).photos[0].camera;
  const ImageF before = render(state.cloud, camera).color;
  const McmcSummary summary = relocate_and_grow(options, 700, state);
  EXPECT_EQ(summary.moved, 61u);
  EXPECT_EQ(summary.added, 100u);
  ASSERT_EQ(state.cloud.size(), 700u);
  EXPECT_EQ(state.sh.first.size(), state.cloud.sh.size());
  for (const Vec3f& x : state.cloud.position) ASSERT_TRUE(x.allFinite());
  for (const float o : state.cloud.opacity_logit) EXPECT_GE(sigmoid(o), options.dead_opacity * 0.999);
  EXPECT_LT(mean_square(before, render(state.cloud, camera).color), 4e-4);
}

TEST(Mcmc, NoiseMovesFaintGaussiansWithinTheirShapeAndLeavesOpaqueOnes) {
  TrainOptions options;
  TrainingState state = state_of(painted_ball(2000, 2));
  for (size_t i = 0; i < 2000; ++i) {
    state.cloud.log_scale[i] = Vec3f(std::log(0.2f), std::log(0.1f), std::log(0.01f));
    state.cloud.opacity_logit[i] = i < 1000 ? logit(0.005f) : 3.0f;
  }
  const std::vector<Vec3f> before = state.cloud.position;
  const float rate = 1e-6f, extent = 4;
  explore(options, rate, extent, state);
  Vec3f square = Vec3f::Zero();
  for (size_t i = 0; i < 1000; ++i) square += (state.cloud.position[i] - before[i]).cwiseAbs2() / 1000;
  for (size_t i = 1000; i < 2000; ++i) EXPECT_EQ(state.cloud.position[i], before[i]);
  // Half of noise * rate * variance * normal, the variance in extents.
  for (int k = 0; k < 3; ++k) {
    const float deviation = 0.5f * options.noise * rate * std::exp(2 * state.cloud.log_scale[0][k]) / (extent * extent);
    EXPECT_NEAR(std::sqrt(square[k]) / deviation, 1, 0.08) << k;
  }
}

TEST(Mcmc, NoiseDoesNotDependOnTheUnitOfLength) {
  TrainOptions options;
  TrainingState metres = state_of(painted_ball(50, 2)), millimetres = metres;
  for (TrainingState* state : {&metres, &millimetres})
    for (float& o : state->cloud.opacity_logit) o = logit(0.005f);
  for (Vec3f& x : millimetres.cloud.position) x *= 1000;
  for (Vec3f& s : millimetres.cloud.log_scale) s.array() += std::log(1000.0f);
  const std::vector<Vec3f> before = metres.cloud.position;
  explore(options, 1e-4f, 3, metres);
  explore(options, 0.1f, 3000, millimetres);
  for (size_t i = 0; i < before.size(); ++i) {
    const float moved = (metres.cloud.position[i] - before[i]).norm();
    EXPECT_GT(moved, 0);
    EXPECT_LT((millimetres.cloud.position[i] / 1000 - metres.cloud.position[i]).norm(), 0.02f * moved + 1e-6f);
  }
}

TEST(Classic, SplitsLargeClonesSmallPrunesFaintAndKeepsTheBudget) {
  TrainOptions options;
  TrainingState state = state_of(painted_ball(100, 3));
  state.screen_gradient.assign(100, 0);
  state.times_seen.assign(100, 2);
  for (int i = 0; i < 30; ++i) state.screen_gradient[i] = 1e-3f + 1e-5f * i;  // mean 5e-4, above the threshold
  for (int i = 0; i < 10; ++i) state.cloud.log_scale[i].setConstant(std::log(1e-3f));
  for (int i = 90; i < 95; ++i) state.cloud.opacity_logit[i] = -9;
  TrainingState copy = state;
  const ClassicSummary summary = clone_split_prune(options, 1.0f, 1000, state);
  EXPECT_EQ(summary.pruned, 5u);
  EXPECT_EQ(summary.cloned, 10u);
  EXPECT_EQ(summary.split, 20u);
  EXPECT_EQ(state.cloud.size(), 125u);
  EXPECT_EQ(state.screen_gradient, std::vector<float>(125, 0.0f));
  // With room for three only those with the largest gradients divide.
  const ClassicSummary tight = clone_split_prune(options, 1.0f, 98, copy);
  EXPECT_EQ(tight.cloned + tight.split, 3u);
  EXPECT_EQ(copy.cloud.size(), 98u);
}

TEST(TrainingRows, StayTogetherWhenGaussiansAreChosen) {
  TrainingState state = state_of(painted_ball(20, 4));
  state.attribute.resize(20 * 16);
  std::iota(state.attribute.begin(), state.attribute.end(), 0.0f);
  fit_moments(state);
  for (size_t k = 0; k < state.position.first.size(); ++k) state.position.first[k] = static_cast<float>(k);
  const GaussianCloud before = state.cloud;
  keep_gaussians(state, std::vector<int>{7, 3, 7});
  ASSERT_EQ(state.cloud.size(), 3u);
  EXPECT_EQ(state.cloud.position[1], before.position[3]);
  EXPECT_EQ(state.cloud.sh_of(2)[1], before.sh_of(7)[1]);
  EXPECT_EQ(state.attribute[16], 3 * 16);
  EXPECT_EQ(state.position.first[8], 7 * 3 + 2);
  raise_sh_degree(state, 2);
  EXPECT_EQ(state.cloud.sh_of(1)[2], before.sh_of(3)[2]);
  EXPECT_EQ(state.cloud.sh_of(1)[3], 0.0f);
  EXPECT_EQ(state.sh.second.size(), state.cloud.sh.size());
}

}  // namespace
}  // namespace pliant
