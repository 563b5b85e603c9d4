// Fields of E and v0 by exact gradients: they find what a twin was made of, and continue where they were stopped.

#include "fitting/fit/fit_gradient.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "fitting/fields/kan_field.h"
#include "fitting/fields/part_field.h"
#include "fitting/fields/triplane_field.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using namespace fixture;

/// A stem whose upper half is three times softer than the motion's particles, and what was seen of it.
struct Problem {
  TwinStem twin;
  std::vector<uint32_t> part;
  Motion<float> motion;
  Objective<float> objective;
  double wanted[2] = {0, std::log(1 / 3.0)};

  explicit Problem(int frames) {
    motion.particles = twin.particles;
    for (size_t i = 0; i < twin.particles.size(); ++i) {
      part.push_back(twin.particles.position[i].z() > 0.05f);
      if (part[i]) twin.particles.young[i] /= 3;
    }
    motion.start = twin.kicked(0.5);
    motion.interactions = twin.pins;
    motion.options.simulate.fps = twin.fps;
    motion.options.simulate.duration = frames / twin.fps;
    motion.options.simulate.damping_time = twin.damping_time;
    objective.terms.push_back(
        {1, std::make_shared<TrackLoss<float>>(twin.film(twin.pins, motion.start, true, frames))});
  }
};

TEST(FitGradient, PartsAndDampingOfATwinAreFound) {
  Problem problem(12);
  problem.motion.options.simulate.damping_time *= 2;
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  options.iterations = 70;
  options.material_rate = 0.05;
  options.damping_rate = 0.05;
  GradientFitState state;
  state.now.material = {0, 0};
  fit_gradient(options, problem.motion, problem.objective, {&field, nullptr, true}, state);
  EXPECT_TRUE(state.finished);
  for (int p = 0; p < 2; ++p) EXPECT_NEAR(state.best.material[p], problem.wanted[p], 0.08) << p;
  EXPECT_NEAR(state.best.damping, std::log(2.0), 0.4);
  EXPECT_LT(state.best_loss, 0.01 * state.rows[0].loss + 1e-3);
}

// A free motion tells E / density: with E known and the total mass kept, where the mass is.
TEST(FitGradient, TheDistributionOfTheMassOfATwinIsFound) {
  Problem problem(12);
  problem.motion.particles.young = problem.twin.particles.young;
  Particles& heavy = problem.twin.particles;
  const double before = heavy.total_mass();
  for (size_t i = 0; i < heavy.size(); ++i) heavy.mass[i] *= problem.part[i] ? 2.0f : 1.0f;
  const auto share = static_cast<float>(before / heavy.total_mass());
  for (float& mass : heavy.mass) mass *= share;
  problem.objective.terms = {
      {1, std::make_shared<TrackLoss<float>>(problem.twin.film(problem.twin.pins, problem.motion.start, true, 12))}};
  const PartField field(problem.part, 1);
  GradientFitFields fields;
  fields.density = &field;
  fields.keep_mass = true;
  GradientFitOptions options;
  options.iterations = 60;
  options.density_rate = 0.05;
  GradientFitState state;
  state.now.density = {0, 0};
  fit_gradient(options, problem.motion, problem.objective, fields, state);
  const Motion<float> found = with_fields(problem.motion, fields, state.best);
  EXPECT_NEAR(found.particles.total_mass(), before, 1e-6 * before);
  for (size_t i = 0; i < heavy.size(); i += heavy.size() - 1)
    EXPECT_NEAR(found.particles.mass[i] / heavy.mass[i], 1, 0.05) << "part " << problem.part[i];
  options.density_limit = 0.1;
  GradientFitState bound;
  bound.now.density = {0, 0};
  fit_gradient(options, problem.motion, problem.objective, fields, bound);
  for (const double p : bound.best.density) EXPECT_LE(std::abs(p), 0.1);
}

TEST(FitGradient, UnderAKnownForceDensityAndStiffnessAreBothFound) {
  Problem problem(12);
  Interaction force;
  force.type = InteractionType::kPointForce;
  force.vector = {0.02, 0.01, 0};
  force.duration = 0.1;
  force.region = Region::half_space(Vec3d(0, 0, 0.07), Vec3d(0, 0, -1));
  problem.motion.interactions.push_back(force);
  problem.motion.start = initial_state(problem.motion.particles);
  Particles& truth = problem.twin.particles;
  truth = problem.motion.particles;
  for (float& mass : truth.mass) mass *= 1.5f;
  for (float& young : truth.young) young *= 0.7f;
  problem.objective.terms = {{1, std::make_shared<TrackLoss<float>>(
                                     problem.twin.film(problem.motion.interactions, problem.motion.start, true, 12))}};
  const PartField field(problem.part.size(), 1);
  GradientFitFields fields{&field};
  fields.density = &field;
  GradientFitOptions options;
  options.iterations = 80;
  options.material_rate = options.density_rate = 0.03;
  GradientFitState state;
  state.now.material = state.now.density = {0};
  fit_gradient(options, problem.motion, problem.objective, fields, state);
  EXPECT_NEAR(state.best.density[0], std::log(1.5), 0.05);
  EXPECT_NEAR(state.best.material[0], std::log(0.7), 0.05);
}

// The gradient is that of the loss, also where the mass that one part gains is lost by the other.
TEST(FitGradient, TheFirstStepGoesDownTheSlopeOfTheDensity) {
  Problem problem(8);
  const PartField field(problem.part, 1);
  for (const bool keep : {false, true}) {
    GradientFitFields fields;
    fields.density = &field;
    fields.keep_mass = keep;
    const auto loss = [&](double lower, double upper) {
      GradientFitParameters at;
      at.density = {lower, upper};
      return motion_loss(with_fields(problem.motion, fields, at), problem.objective);
    };
    constexpr double kStep = 0.02;
    const double slope[2] = {loss(kStep, 0) - loss(-kStep, 0), loss(0, kStep) - loss(0, -kStep)};
    GradientFitOptions options;
    options.iterations = 1;
    options.growth = 0;
    options.first_window = 8;
    GradientFitState state;
    state.now.density = {0, 0};
    fit_gradient(options, problem.motion, problem.objective, fields, state);
    // Adam's first moment is a tenth of the gradient, which is cut to length 1.
    const double length = std::hypot(slope[0], slope[1]), cut = 0.1 * std::min(1.0, length / (2 * kStep));
    for (int p = 0; p < 2; ++p) EXPECT_NEAR(state.first_moment[p], cut * slope[p] / length, 0.02 * cut) << keep << p;
  }
}

TEST(FitGradient, AtTheBestItStaysThereHoweverLargeTheRates) {
  Problem problem(8);
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  options.iterations = 12;
  options.growth = 0;
  options.material_rate = 0.4;
  options.astray = 0.02;
  GradientFitState state;
  // So near the best that it makes no difference, where gradients are not exactly zero.
  state.now.material = {problem.wanted[0] + 1e-5, problem.wanted[1] - 1e-5};
  fit_gradient(options, problem.motion, problem.objective, {&field}, state);
  EXPECT_LE(state.best_loss, state.rows[0].loss);
  EXPECT_LT(state.rate, 0.3);
  // The last iterations, led back, lie nearer to it than the first step.
  double last = INFINITY;
  for (size_t k = 8; k < 12; ++k) last = std::min(last, state.rows[k].loss);
  EXPECT_LT(last - state.rows[0].loss, 0.3 * (state.rows[1].loss - state.rows[0].loss));
}

TEST(FitGradient, AnAddedYoungIsFoundAndStaysBetweenItsBounds) {
  Problem problem(8);
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  options.iterations = 40;
  options.growth = 0;
  options.material_rate = 0.05;
  GradientFitFields fields{&field};
  for (const double low : {0.0, 1.5e4}) {
    fields.added_young = {3e4, low, INFINITY};  // Pa; the upper half has 1e4
    GradientFitState state;
    state.now.material = {0, 0};
    fit_gradient(options, problem.motion, problem.objective, fields, state);
    const Motion<float> found = with_fields(problem.motion, fields, state.best);
    EXPECT_NEAR(found.particles.young.back(), std::max(1e4, low), 1e3);
    EXPECT_GE(found.particles.young.back(), low);
  }
}

/// Adam's first step has the size of its rate.
TEST(FitGradient, RatesRiseInTheWarmUpFallInALineAndDecayWeights) {
  Problem problem(8);
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  options.iterations = 40;
  options.growth = 0;
  options.material_rate = 0.01;
  options.warm_up = 10;
  options.linear = true;
  const auto first_step = [&](double weight_decay) {
    options.weight_decay = weight_decay;
    GradientFitState state;
    state.now.material = {0.5, 0.5};
    fit_gradient(options, problem.motion, problem.objective, {&field}, state,
                 [](const GradientFitState&) { return false; });
    return state.now.material[1] - 0.5;
  };
  const double rate = 0.01 / 10;
  EXPECT_NEAR(first_step(0), -rate, 1e-9);  // the upper half is softer
  EXPECT_NEAR(first_step(0.2), -rate * (1 + 0.2 * 0.5), 1e-9);
  options.warm_up = 0;
  EXPECT_NEAR(first_step(0), -0.01, 1e-8);
}

TEST(FitGradient, TheWindowGrowsFromSixFramesToAll) {
  Problem problem(12);
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  const std::vector<double> start = {0, 0};
  for (const auto& [growth, iterations] : {std::pair{0.5, 5}, {1.0, 4}, {0.5, 1}, {1.0, 1}}) {
    options.growth = growth;
    options.iterations = iterations;
    GradientFitState state;
    state.now.material = start;
    fit_gradient(options, problem.motion, problem.objective, {&field}, state);
    EXPECT_EQ(state.rows.front().frames, iterations == 1 ? 12 : 6);
    EXPECT_EQ(state.rows.back().frames, 12);
    for (size_t k = 1; k < state.rows.size(); ++k) EXPECT_GE(state.rows[k].frames, state.rows[k - 1].frames);
    // Steps of 0.01 towards ln(1 / 3) lower the loss of all frames, the last one too.
    EXPECT_NE(state.best.material, start) << growth << ' ' << iterations;
    const double loss = motion_loss(with_fields(problem.motion, {&field}, state.best), problem.objective);
    EXPECT_NEAR(state.best_loss, loss, 1e-6 * loss);
  }
}

TEST(FitGradient, OfNoisyLossesTheResultIsWhatTheLastStepLeadsTo) {
  Problem problem(6);
  const PartField field(problem.part, 1);
  GradientFitOptions options;
  options.growth = 0;
  options.noisy = true;
  const auto fit = [&](int iterations, GradientFitState state, int stop = 100) {
    if (state.now.material.empty()) state.now.material = {0, 0};
    options.iterations = iterations;
    fit_gradient(options, problem.motion, problem.objective, {&field}, state,
                 [&](const GradientFitState& s) { return static_cast<int>(s.rows.size()) != stop; });
    return state;
  };
  const GradientFitState one = fit(1, {});
  EXPECT_EQ(one.best.material, one.now.material);
  EXPECT_NE(one.best.material, (std::vector<double>{0, 0}));
  const GradientFitState whole = fit(2, {}), stopped = fit(2, {}, 1);
  ASSERT_EQ(stopped.rows.size(), 1u);
  EXPECT_EQ(whole.best.material, whole.now.material);
  EXPECT_EQ(fit(2, stopped).best.material, whole.best.material);
  // Stopped after the last step, it has nothing left to do.
  EXPECT_EQ(fit(2, fit(2, {}, 2)).best.material, whole.best.material);
}

TEST(FitGradient, AStoppedFitContinuesToTheSameNumbersBitForBit) {
  Problem problem(6);
  const PartField material(problem.part, 1), velocity(problem.part, 3);
  const GradientFitFields fields{&material, &velocity, true, &material, {}, &material, true};
  GradientFitOptions options;
  options.iterations = 6;
  const auto begun = [] {
    GradientFitState state;
    state.now.material = {0, 0};
    state.now.velocity.assign(6, 0.0);
    state.now.poisson = state.now.density = {0, 0};
    return state;
  };
  GradientFitState whole = begun(), stopped = begun();
  fit_gradient(options, problem.motion, problem.objective, fields, whole);
  fit_gradient(options, problem.motion, problem.objective, fields, stopped,
               [](const GradientFitState& s) { return s.rows.size() < 3; });
  ASSERT_EQ(stopped.rows.size(), 3u);
  fit_gradient(options, problem.motion, problem.objective, fields, stopped);
  EXPECT_EQ(whole.now.material, stopped.now.material);
  EXPECT_EQ(whole.now.velocity, stopped.now.velocity);
  EXPECT_EQ(whole.now.poisson, stopped.now.poisson);
  EXPECT_EQ(whole.now.density, stopped.now.density);
  EXPECT_EQ(whole.best_loss, stopped.best_loss);
}

/// Median error of log10 E, in the free part, of what Adam finds with this field.
double error_of_two_parts(const Problem& problem, const Field& field) {
  GradientFitState state;
  state.now.material = field.constant(std::vector<double>{0.0});
  fit_gradient({}, problem.motion, problem.objective, {&field}, state);
  const std::vector<double> factor = field.values(state.best.material);
  std::vector<double> error;
  for (size_t i = 0; i < factor.size(); ++i)
    if (problem.motion.particles.position[i].z() > 0.015f)
      error.push_back(std::abs(factor[i] - problem.wanted[problem.part[i]]) / std::log(10.0));
  std::nth_element(error.begin(), error.begin() + error.size() / 2, error.end());
  return error[error.size() / 2];
}

TEST(FitGradient, TriplanesFindTwoParts) {
  if (!has_triplane_fields()) GTEST_SKIP() << "built without libtorch";
  const Problem problem(12);
  EXPECT_LT(error_of_two_parts(problem, *make_triplane_field({}, problem.motion.particles.position)), 0.15);
}

TEST(FitGradient, AKanFindsTwoParts) {
  const Problem problem(12);
  EXPECT_LT(error_of_two_parts(problem, KanField({}, problem.motion.particles.position)), 0.15);
}

}  // namespace
}  // namespace pliant
