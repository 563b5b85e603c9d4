// PhysDreamer's recipe on a twin: v0 from three frames under a given E, then E from there.

#include "fitting/fit/fit_physdreamer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using fixture::TwinStem;

MaterialFitOptions recipe(MaterialKind kind, int iterations) {
  MaterialFitOptions options;
  options.kind = kind;
  options.gradient.iterations = iterations;
  options.gradient.material_rate = 0.05;
  return options;
}

/// Of all particles of a stem above a height.
Vec3d momentum(const SimulationState& state, const TwinStem& twin, float above) {
  Vec3d sum = Vec3d::Zero();
  for (size_t i = 0; i < state.size(); ++i)
    if (twin.particles.position[i].z() > above) sum += twin.particles.mass[i] * state.v[i].cast<double>();
  return sum;
}

double degrees_between(const Vec3d& a, const Vec3d& b) {
  return 180 / std::numbers::pi * std::acos(a.normalized().dot(b.normalized()));
}

TEST(FitPhysDreamer, WithTheRightStiffnessThreeFramesTellTheDirectionOfTheStart) {
  const TwinStem twin;
  const SimulationState truth = twin.kicked(0.5);
  const TrackLoss<float> tracks = twin.film(twin.pins, truth, false, 5, 20);
  const MaterialFit fit =
      fit_physdreamer(recipe(MaterialKind::kUniform, 60), twin.particles, twin.pins, tracks, twin.fps);
  const SimulationState& start = fit.homogeneous.start;
  EXPECT_LT(degrees_between(momentum(start, twin, 0), momentum(truth, twin, 0)), 5);
  EXPECT_LT(degrees_between(momentum(start, twin, 0.075f), momentum(truth, twin, 0.075f)), 5);
  EXPECT_NEAR(momentum(start, twin, 0.075f).norm() / momentum(truth, twin, 0.075f).norm(), 1, 0.2);
  // What is held stands still.
  for (size_t i = 0; i < start.size(); ++i)
    EXPECT_EQ(start.v[i].isZero(0), twin.particles.position[i].z() <= 0.015f) << i;
}

TEST(FitPhysDreamer, FromHalfTheStiffnessTheRecipeComesNearerAndContinuesToTheSameBits) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 12, 20);
  Particles guess = twin.particles;
  for (float& E : guess.young) E /= 2;
  const auto recipe_from = [&](MaterialFitProgress kept) {
    return fit_physdreamer(recipe(MaterialKind::kUniform, 24), guess, twin.pins, tracks, twin.fps, {}, std::move(kept));
  };
  MaterialFitProgress first, second, third;
  first.keep_velocity = [&](const GradientFitState& state) {
    if (state.rows.size() == 20) second.velocity = state;
    third.velocity = state;
    return true;
  };
  first.keep_gradient = [&](const GradientFitState& state) {
    if (state.rows.size() == 20) third.gradient = state;
    return true;
  };
  const MaterialFit fit = recipe_from(first);
  ASSERT_EQ(fit.steps.size(), 2u);
  EXPECT_EQ(fit.steps[0].name, "velocity");
  EXPECT_EQ(fit.steps[1].name, "material");
  EXPECT_LT(fit.steps[0].loss.back(), 0.2 * fit.steps[0].loss.front());
  for (const FitStep& step : fit.steps) EXPECT_FALSE(step.stopped_by.empty());
  EXPECT_EQ(fit.iterations.front().frames, 6);
  EXPECT_EQ(fit.iterations.back().frames, 12);
  EXPECT_LT(std::abs(std::log(fit.young[0] / twin.particles.young[0])), 0.5 * std::log(2.0));
  EXPECT_LT(fit.found.rms, 0.5 * fit.homogeneous.rms);  // E moved after v0
  for (const MaterialFitProgress& interrupted : {second, third}) {
    const MaterialFit continued = recipe_from(interrupted);
    EXPECT_EQ(continued.young, fit.young);
    EXPECT_EQ(continued.found.start.v, fit.found.start.v);
  }
}

TEST(FitPhysDreamer, AfterAPushItBeginsWhereTheStemSwingsBackThroughItsShapeAtRest) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, 40);
  const MaterialFit fit =
      fit_physdreamer(recipe(MaterialKind::kUniform, 30), twin.particles, twin.pins, tracks, twin.fps);
  const int first = fit.homogeneous.first_frame;
  EXPECT_GT(first, 6);  // the push lasts to there
  EXPECT_LT(first, 25);
  const std::vector<SimulationState> rest = {initial_state(twin.particles)};
  const auto away = [&](int f) { return tracks.on_rollout(f, f, 0, 1).rms(rest); };
  for (const int beside : {-1, 1}) EXPECT_LE(away(first), away(first + beside));
  EXPECT_LT(fit.found.rms, 0.5 * fit.homogeneous.rms_rest);
  // Told when to begin, it does.
  MaterialFitOptions told = recipe(MaterialKind::kUniform, 1);
  told.vibration.search.first = 0;
  EXPECT_EQ(fit_physdreamer(told, twin.particles, twin.pins, tracks, twin.fps).homogeneous.first_frame, 0);
}

/// The published windows: all three frames for v0, one for E.  A gradient of v0 that was cut after one frame, too,
/// would learn from the first frame alone.
TEST(FitPhysDreamer, AWindowOfOneFrameCutsTheGradientOfStiffnessNotThatOfTheStart) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 8, 20);
  const auto with_window = [&](int window) {
    MaterialFitOptions options = recipe(MaterialKind::kUniform, 6);
    options.gradient_window = window;
    Particles guess = twin.particles;
    for (float& E : guess.young) E /= 2;
    return fit_physdreamer(options, guess, twin.pins, tracks, twin.fps);
  };
  const MaterialFit whole = with_window(0), cut = with_window(1);
  ASSERT_EQ(cut.steps.size(), 2u);
  EXPECT_EQ(cut.steps[0].loss, whole.steps[0].loss);
  EXPECT_EQ(cut.found.start.v, whole.found.start.v);
  EXPECT_NE(cut.young, whole.young);
}

/// E = E0 + 1000 f(x) in a cube: a network's output of a few units, in steps of 1000 Pa times the square of the edge.
TEST(FitPhysDreamer, TheReleasedCodeMovesEInStepsOfItsCubeHoweverLargeEIs) {
  if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 8, 20);
  MaterialFitOptions options = recipe(MaterialKind::kTriplanes, 6);
  options.gradient.material_rate = 0.01;  // of the released code
  options.gradient_window = 1;
  const auto change = [&](double edge) {
    options.released_code = PhysDreamerCode{edge};
    Particles guess = twin.particles;
    for (float& E : guess.young) E /= 2;
    const MaterialFit fit = fit_physdreamer(options, guess, twin.pins, tracks, twin.fps);
    EXPECT_EQ(fit.steps[0].loss.size(), fit.steps[1].loss.size() + 3);  // half as many iterations again for v0
    double most = 0;
    for (size_t i = 0; i < fit.young.size(); ++i) most = std::max(most, std::abs(fit.young[i] - guess.young[i]));
    return most;
  };
  const double usual = change(0.162);  // 1.8 times 90 mm
  EXPECT_GT(usual, 0);
  EXPECT_LT(usual, PhysDreamerCode::kYoungStep * 0.162 * 0.162);
  EXPECT_NEAR(change(2 * 0.162) / usual, 4, 0.5);
  // The last iteration compares all frames, however many more than iterations there are.
  const TrackLoss<float> longer = twin.film(twin.pins, twin.kicked(0.5), true, 12, 20);
  options.gradient.iterations = 2;
  EXPECT_EQ(fit_physdreamer(options, twin.particles, twin.pins, longer, twin.fps).iterations.back().frames, 12);
}

TEST(FitPhysDreamer, FirstFramesInWhichNothingWasFollowedAreRefused) {
  const TwinStem twin;
  PointTracks seen = twin.film(twin.pins, twin.kicked(0.5), true, 8).tracks();
  for (size_t f = 0; f < 4; ++f) seen.weight[f].assign(seen.rest.size(), 0.0);
  MaterialFitOptions options = recipe(MaterialKind::kUniform, 1);
  options.vibration.search.first = 0;
  expect_error(Failure::kInput, {"video", "no followed point", "--video-mask", "--start"}, [&] {
    fit_physdreamer(options, twin.particles, twin.pins, TrackLoss<float>(seen, twin.drivers, 1, 2), twin.fps);
  });
}

TEST(FitPhysDreamer, AVideoOfThreeFramesIsRefused) {
  const TwinStem twin;
  EXPECT_THROW(
      fit_physdreamer({}, twin.particles, twin.pins, twin.film(twin.pins, twin.kicked(0.5), true, 3, 5), twin.fps),
      Error);
}

}  // namespace
}  // namespace pliant
