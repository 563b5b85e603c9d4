// Twin experiments: tracks of a stem of known stiffness and damping, a start that is wrong by 30 times.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "fitting/fields/part_field.h"
#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using fixture::TwinStem;

TEST(FitVibration, FindsStiffnessAndDampingOfATwinFromAStartThirtyTimesWrong) {
  const TwinStem twin;
  for (const double wrong : {30.0, 1 / 30.0}) {
    const bool in_picture = wrong > 1;
    const TrackLoss<float> tracks = twin.pushed(in_picture, 0.02, 40);
    Particles guess = twin.particles;
    for (float& E : guess.young) E = static_cast<float>(E * wrong);
    VibrationFitOptions options;
    options.modes.most = 6;
    const VibrationFit fit = fit_vibration(options, guess, twin.pins, tracks, twin.fps);
    EXPECT_NEAR(fit.log10_factor + std::log10(wrong), 0, 0.02);
    EXPECT_NEAR(fit.damping_time / twin.damping_time, 1, 0.2);
    EXPECT_LT(fit.rms, 0.05 * fit.rms_rest);
    EXPECT_GE(fit.first_frame, 4);  // the force ends at 0.12 s = frame 6; before, the motion is not free
    EXPECT_GT(fit.search.periods, 1);
  }
}

TEST(FitVibration, FindsStiffnessFromTracksThatBeginAwayFromRest) {
  const TwinStem twin;
  PointTracks seen = twin.pushed(true, 0.02, 40).tracks();
  constexpr int kReleased = 7;
  seen.place.erase(seen.place.begin(), seen.place.begin() + kReleased);
  seen.weight.erase(seen.weight.begin(), seen.weight.begin() + kReleased);
  Particles guess = twin.particles;
  for (float& E : guess.young) E *= 4;
  VibrationFitOptions options;
  options.modes.most = 4;
  options.candidates = 1;
  options.search.first = 0;
  const VibrationFit fit =
      fit_vibration(options, guess, twin.pins, TrackLoss<float>(seen, twin.drivers, 1, 2), twin.fps);
  EXPECT_EQ(fit.first_frame, 0);
  EXPECT_NEAR(fit.log10_factor + std::log10(4), 0, 0.02);
  EXPECT_LT(fit.rms, 0.1 * fit.rms_rest);
}

TEST(FitVibration, TheErrorOfAStillBodyIsThatOfTheFramesCompared) {
  const TwinStem twin;
  constexpr int kFrames = 60;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, kFrames);
  VibrationFitOptions options;
  options.modes.most = 3;
  options.candidates = 1;
  options.refine.max_iterations = 1;
  options.most_periods = 1;
  const VibrationFit fit = fit_vibration(options, twin.particles, twin.pins, tracks, twin.fps);
  ASSERT_LT(fit.last_frame, 3 * kFrames / 4);
  const auto still_until = [&](int last) {
    const std::vector<SimulationState> still(last - fit.first_frame + 1, initial_state(twin.particles));
    return tracks.on_rollout(fit.first_frame, last, 0, 1).rms(still);
  };
  EXPECT_NEAR(fit.rms_rest / still_until(fit.last_frame), 1, 1e-6);
  EXPECT_GT(fit.rms_rest, 1.1 * still_until(kFrames)) << "later frames, in which the motion dies away, do not count";
}

TEST(FitVibration, AStiffnessFromTheEndOfTheSearchIsOpenByADecadeAtLeast) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, 20);
  Particles guess = twin.particles;
  for (float& E : guess.young) E *= 1e-3f;
  VibrationFitOptions options;
  options.modes.most = 3;
  options.candidates = 1;
  options.refine.max_iterations = 1;
  options.most_periods = 1;
  options.search.farthest = 2;
  const VibrationFit fit = fit_vibration(options, guess, twin.pins, tracks, twin.fps);
  EXPECT_EQ(fit.search.end, 1);
  EXPECT_GE(fit.log10_sigma, 1);
  for (const double sigma : fit.young_sigma) EXPECT_GE(sigma, 1);
}

TEST(FitVibration, IsEqualBitForBitForAnyNumberOfThreads) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, 20);
  Particles guess = twin.particles;
  for (float& E : guess.young) E *= 3;
  VibrationFitOptions options;
  options.modes.most = 3;
  options.candidates = 1;
  options.refine.max_iterations = 3;
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const VibrationFit one = fit_vibration(options, guess, twin.pins, tracks, twin.fps);
  omp_set_num_threads(3);
  const VibrationFit three = fit_vibration(options, guess, twin.pins, tracks, twin.fps);
  omp_set_num_threads(before);
  EXPECT_EQ(one.log10_factor, three.log10_factor);
  EXPECT_EQ(one.damping_time, three.damping_time);
  EXPECT_EQ(one.start.v, three.start.v);
  EXPECT_EQ(one.modes.shape, three.modes.shape);
  EXPECT_EQ(one.young_sigma, three.young_sigma);
}

TEST(FitVibration, InterruptedBetweenAnyTwoIterationsItEndsWithTheSameBits) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.film(twin.pins, twin.kicked(0.5), true, 6, 6, 0.05);
  Particles guess = twin.particles;
  std::vector<uint32_t> part;
  for (size_t i = 0; i < guess.size(); ++i) {
    part.push_back(guess.position[i].z() > 0.05f);
    guess.young[i] *= part.back() ? 2.0f : 1.5f;
  }
  VibrationFitOptions options;
  options.modes.most = 2;
  options.candidates = 2;
  options.most_smooth = 2;
  options.refine.max_iterations = 5;
  options.search.low = -0.4;
  options.search.high = 0.4;
  for (const bool field : {false, true}) {
    if (field) {
      options.field = std::make_shared<PartField>(part, 1);
      options.field_sigma = 1;
      options.factor_sigma = 0.05;
    }
    std::vector<VibrationFitState> states;
    const auto fit = [&](const VibrationFitState& from, const VibrationFitSink& sink) {
      return fit_vibration(options, guess, twin.pins, tracks, twin.fps, {}, from, sink);
    };
    const VibrationFit whole = fit({}, [&](const VibrationFitState& state) { states.push_back(state); });
    ASSERT_GT(states.size(), 8u);
    EXPECT_NE(field, states[0].modes && states[0].refinements.empty());
    size_t again = 0;
    for (const double share : {field ? 0.2 : 0.0, 0.7}) {
      const size_t k = std::lround(share * static_cast<double>(states.size() - 1));
      const VibrationFit continued = fit(states[k], [&](const VibrationFitState&) { ++again; });
      EXPECT_EQ(continued.log10_factor, whole.log10_factor) << k << " of " << states.size();
      EXPECT_EQ(continued.damping_time, whole.damping_time);
      EXPECT_EQ(continued.field, whole.field);
      EXPECT_EQ(continued.young_sigma, whole.young_sigma);
      EXPECT_EQ(continued.start.v, whole.start.v);
      EXPECT_EQ(continued.summary.loss, whole.summary.loss);
      EXPECT_EQ(continued.rms, whole.rms);
      EXPECT_EQ(continued.substeps, whole.substeps);
      // Nothing is done twice.
      EXPECT_EQ(again, states.size() - 1 - k);
      again = 0;
    }
    options.known_modes = whole.modes;
  }
}

TEST(FitVibration, AMinimumThatCannotBeSimulatedIsPassedOver) {
  const TwinStem twin;
  PointTracks seen = twin.film(twin.pins, twin.kicked(0.3), true, 30).tracks();
  // Seen in every fifth frame alone, a vibration looks like faster ones too.
  for (size_t f = 0; f < seen.weight.size(); ++f)
    if (f % 5 != 0) seen.weight[f].assign(seen.rest.size(), 0.0);
  const TrackLoss<float> tracks(seen, twin.drivers, 1, 2);
  VibrationFitOptions options;
  options.modes.most = 2;
  options.search.first = 0;
  options.search.low = -0.2;
  options.search.high = options.search.farthest = 1;
  options.refine.max_iterations = 1;
  options.most_smooth = 2;
  std::string said;
  const auto fit = [&](int unstable, VibrationFitState from = {}, const VibrationFitSink& sink = {}) {
    std::atomic<int> rollouts = 0;
    options.stop = [&]() -> bool {
      if (rollouts++ < unstable) throw numerical_error("simulate", "is unstable", "");
      return false;
    };
    said.clear();
    return fit_vibration(
        options, twin.particles, twin.pins, tracks, twin.fps, [&](const std::string& line) { said += line + '\n'; },
        std::move(from), sink);
  };
  const VibrationFit all = fit(0);
  ASSERT_GE(all.candidate_factor.size(), 2u);
  EXPECT_EQ(said.find("cannot be simulated"), std::string::npos);
  VibrationFitState last;
  const VibrationFit others = fit(1, {}, [&](const VibrationFitState& state) { last = state; });
  EXPECT_NE(said.find("cannot be simulated"), std::string::npos);
  EXPECT_EQ(others.candidate_factor, std::vector<double>(all.candidate_factor.begin() + 1, all.candidate_factor.end()));
  EXPECT_EQ(fit(1, last).start.v, others.start.v) << "and when it goes on";
  // The periods are those of the minimum that was refined; the first of the others is the second one.
  const std::vector<double>& rms = others.candidate_rms;
  const auto refined = static_cast<size_t>(1 + (std::min_element(rms.begin(), rms.end()) - rms.begin()));
  EXPECT_EQ(others.search.periods, others.search.minima.at(refined).periods);
  EXPECT_NE(others.search.periods, others.search.minima[0].periods);
  expect_error(Failure::kNumerical, {"is unstable"}, [&] { fit(1000); });
}

TEST(FitVibration, FramesInWhichNothingWasFollowedAreRefused) {
  const TwinStem twin;
  PointTracks seen = twin.film(twin.pins, twin.kicked(0.3), true, 60).tracks();
  for (size_t f = 0; f < 50; ++f) seen.weight[f].assign(seen.rest.size(), 0.0);
  VibrationFitOptions options;
  options.modes.most = 2;
  options.search.first = 0;
  options.search.low = -0.1;
  options.search.high = options.search.farthest = 0.1;
  options.most_periods = 1;
  expect_error(Failure::kInput, {"video", "no followed point", "--video-mask"}, [&] {
    fit_vibration(options, twin.particles, twin.pins, TrackLoss<float>(seen, twin.drivers, 1, 2), twin.fps);
  });
}

TEST(FitVibration, ABodyThatStandsStillIsRefused) {
  const TwinStem twin;
  EXPECT_THROW(fit_vibration({}, twin.particles, twin.pins, twin.pushed(true, 0, 10), twin.fps), Error);
}

}  // namespace
}  // namespace pliant
