// How sure the tracks of a twin make its E from place to place.

#include "fitting/fit/young_posterior.h"

#include <gtest/gtest.h>

#include <atomic>

#include "fitting/fields/part_field.h"
#include "fitting/fields/smooth_field.h"
#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using fixture::TwinStem;

Motion<float> motion_of(const TwinStem& twin, const SimulationState& start, int frames) {
  Motion<float> motion{twin.particles, start, twin.pins, {}};
  motion.options.simulate.fps = twin.fps;
  motion.options.simulate.duration = frames / twin.fps;
  motion.options.simulate.damping_time = twin.damping_time;
  motion.options.simulate.substeps =
      rollout<float>(motion.options, motion.particles, motion.interactions, motion.start).substeps;
  return motion;
}

TEST(YoungPosterior, WhatNeverMovesKeepsThePriorAndWhatBendsIsDetermined) {
  TwinStem twin;
  twin.pins[0].region = Region::half_space(Vec3d(0, 0, 0.05), Vec3d(0, 0, 1));
  const SimulationState start = twin.kicked(0.5);
  SmoothFieldOptions options;
  options.modes = 32;
  options.length = 0.01;
  const SmoothField field(options, twin.particles.position);
  const YoungPosterior found =
      posterior_about(motion_of(twin, start, 10), field, 1, twin.film(twin.pins, start, true, 10, 20, 0.05));
  const double decade = std::log(10.0), prior = options.sigma / decade;
  double least_below = INFINITY, most_bent = 0, most = 0;
  for (size_t i = 0; i < twin.particles.size(); ++i) {
    const float z = twin.particles.position[i].z();
    const double share = std::hypot(found.young_sigma[i], std::sqrt(field.variance_left_out(i)) / decade) / prior;
    most = std::max(most, share);
    // Nothing below 3.7 cm moves; up to about two lengths of the field below, its smoothness tells of it.
    if (z < 0.01f) least_below = std::min(least_below, share);
    if (z > 0.052f && z < 0.058f) most_bent = std::max(most_bent, share);
  }
  EXPECT_GT(least_below, 0.85);
  EXPECT_LT(most_bent, 0.4);
  EXPECT_LT(most, 1 + 1e-6);
  EXPECT_GT(found.log_damping_sigma, 0);
  EXPECT_LT(found.log_damping_sigma, 1);
}

TEST(YoungPosterior, OfOneStiffnessCoversTheErrorsOfRepeatedMeasurements) {
  // Tracks with noise pull ln E away from the truth by about one sigma: twice the noise, twice the sigma.
  const TwinStem twin;
  const SimulationState start = twin.kicked(0.5);
  const PartField field(twin.particles.size(), 1);
  const Motion<float> motion = motion_of(twin, start, 8);
  const auto sigma = [&](double noise) {
    return posterior_about(motion, field, INFINITY, twin.film(twin.pins, start, true, 8, 20, noise)).log10_sigma;
  };
  const double one = sigma(0.05), two = sigma(0.1);
  EXPECT_GT(one, 0);
  EXPECT_NEAR(two / one, 2, 0.3);
  EXPECT_THROW(
      posterior_about(motion, field, INFINITY, twin.film(twin.pins, start, true, 8, 20, 0.1), [] { return true; }),
      Error);
}

// As of a part whose stiffness has stopped at its bound.
TEST(YoungPosterior, AParameterOfInfiniteVarianceLeavesOpenOnlyWhatDependsOnIt) {
  const double decade = std::log(10.0);
  Eigen::MatrixXd by(3, 3), covariance = Eigen::MatrixXd::Zero(3, 3);
  by << 1, 1, 0, 1, 0, 1, 1, 0, 0;  // a common factor, and that of a part
  covariance.diagonal() << 0.04, 0.09, INFINITY;
  const YoungPosterior open = young_posterior(by, covariance);
  ASSERT_EQ(open.young_sigma.size(), 3u);
  EXPECT_NEAR(open.young_sigma[0], std::sqrt(0.13) / decade, 1e-12);
  EXPECT_EQ(open.young_sigma[1], INFINITY);
  EXPECT_NEAR(open.young_sigma[2], 0.2 / decade, 1e-12);
  EXPECT_EQ(open.log10_sigma, INFINITY);
  const std::vector<double> prior = {9, 9, 0.5};
  const YoungPosterior expected = young_posterior(by, with_prior_where_infinite(covariance, prior));
  EXPECT_NEAR(expected.young_sigma[0], open.young_sigma[0], 1e-12);
  EXPECT_NEAR(expected.young_sigma[1], std::sqrt(0.04 + 0.25) / decade, 1e-12);
  EXPECT_NEAR(expected.log10_sigma, std::sqrt(0.04 + (0.09 + 0.25) / 9) / decade, 1e-12);
}

TEST(YoungPosterior, GoesOnFromWhereItWasInterrupted) {
  const TwinStem twin;
  const SimulationState start = twin.kicked(0.5);
  const PartField field(twin.particles.size(), 1);
  const Motion<float> motion = motion_of(twin, start, 8);
  const TrackLoss<float> tracks = twin.film(twin.pins, start, true, 8, 20, 0.1);
  std::vector<PosteriorState> kept;
  std::atomic<int> asked = 0;
  const auto never = [&] { return ++asked, false; };
  const YoungPosterior whole = posterior_about(motion, field, INFINITY, tracks, never, {},
                                               [&](const PosteriorState& state) { kept.push_back(state); });
  const int all = asked.exchange(0);
  ASSERT_GE(kept.size(), 2u);
  const YoungPosterior rest = posterior_about(motion, field, INFINITY, tracks, never, kept[0]);
  EXPECT_EQ(rest.young_sigma, whole.young_sigma);
  EXPECT_EQ(rest.log_damping_sigma, whole.log_damping_sigma);
  EXPECT_LT(asked.load(), all);
}

}  // namespace
}  // namespace pliant
