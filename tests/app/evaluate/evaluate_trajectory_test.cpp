// Trajectories against trajectories, and the frequency of sampled values.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/metrics.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

TEST(Frequency, OfADecayingOscillationIsFoundByBothMethods) {
  for (double hertz : {0.9, 1.7, 3.2}) {
    std::vector<double> values;
    for (int i = 0; i < 90; ++i) {
      const double t = i / 30.0;
      values.push_back(0.2 + 0.05 * t + std::exp(-0.4 * t) * std::cos(2 * M_PI * hertz * t + 0.3));
    }
    EXPECT_NEAR(dominant_frequency(values, 30), hertz, 0.05) << hertz;
    EXPECT_NEAR(zero_crossing_frequency(values, 30), hertz, 0.12) << hertz;
  }
  EXPECT_EQ(dominant_frequency(std::vector<double>(50, 1.0), 30), 0);
  EXPECT_EQ(zero_crossing_frequency(std::vector<double>(50, 1.0), 30), 0);
}

TEST(Frequency, BelowOnePeriodTheScanEndsWithoutLeavingIt) {
  std::vector<double> values;
  for (int i = 0; i < 48; ++i) values.push_back(std::cos(2 * M_PI * 0.3 * i / 24.0));
  // The transform falls over the whole scan, which begins at 1 / 2 s.
  EXPECT_GE(dominant_frequency(values, 24), 0.5);
}

/// A rod of unit height along z that sways along x, `amplitude` at the tip; what hangs sways at its lower end.
TrajectoryFile swaying(int particles, int frames, double fps, double hertz, double amplitude, bool hangs = false) {
  TrajectoryFile t;
  t.fps = fps;
  t.up = {0, 0, 1};
  for (int f = 0; f < frames; ++f) {
    TrajectoryFile::Frame frame;
    frame.time = f / fps;
    const double decay = 0.3, phase = 2 * M_PI * hertz * frame.time,
                 envelope = amplitude * std::exp(-decay * frame.time), sway = envelope * std::sin(phase),
                 speed = envelope * (2 * M_PI * hertz * std::cos(phase) - decay * std::sin(phase));
    for (int p = 0; p < particles; ++p) {
      const double z = p / (particles - 1.0), reach = hangs ? 1 - z : z;
      frame.position.push_back(Vec3d(sway * reach, 0, z).cast<float>());
      frame.velocity.push_back(Vec3d(speed * reach, 0, 0).cast<float>());
    }
    frame.F.assign(particles, Mat3f::Identity());
    t.frames.push_back(frame);
  }
  return t;
}

TEST(EvaluateTrajectory, OfItselfIsWithoutErrorAndItsFrequencyIsFound) {
  const TemporaryFolder folder;
  write_trajectory(folder / "trajectory.h5", swaying(101, 90, 30, 2.0, 0.2), "{}");
  const json out = evaluate_trajectory(folder / "trajectory.h5", folder.path());
  EXPECT_EQ(out["position_error_max"], 0);
  EXPECT_NEAR(out["tip"]["dominant_frequency"].get<double>(), 2.0, 0.05);
  EXPECT_NEAR(out["tip"]["peak"].get<double>(), 0.2 * 0.955 * std::exp(-0.3 / 8), 0.006);
  EXPECT_EQ(out["frequency_error"], 0);
  EXPECT_EQ(out["height"], 1.0);
}

TEST(EvaluateTrajectory, OtherParticlesRatesAndAmplitudesGiveTheKnownError) {
  const TemporaryFolder folder;
  write_trajectory(folder / "truth.h5", swaying(401, 72, 24, 1.5, 0.2), "{}");
  write_trajectory(folder / "same.h5", swaying(200, 360, 120, 1.5, 0.2), "{}");
  EXPECT_LT(evaluate_trajectory(folder / "same.h5", folder / "truth.h5")["position_error_max"], 1.5e-3);
  write_trajectory(folder / "half.h5", swaying(401, 72, 24, 1.5, 0.1), "{}");
  const json out = evaluate_trajectory(folder / "half.h5", folder / "truth.h5");
  EXPECT_NEAR(out["peak_error"].get<double>(), 0.5, 1e-4);
  EXPECT_NEAR(out["relative_error"].get<double>(), 0.5, 1e-3);
  EXPECT_NEAR(out["tip_error_mean"].get<double>() / 0.95, out["position_error_mean"].get<double>() * 2, 2e-3);
  write_trajectory(folder / "slow.h5", swaying(401, 72, 24, 1.2, 0.2), "{}");
  EXPECT_NEAR(evaluate_trajectory(folder / "slow.h5", folder / "truth.h5")["frequency_error"].get<double>(), 0.2, 0.03);
}

TEST(EvaluateTrajectory, AFrequencyOfOnePeriodInTheRecordIsFound) {
  const TemporaryFolder folder;
  // 0.8 and 1.2 periods remain after the peak.
  write_trajectory(folder / "truth.h5", swaying(51, 48, 24, 0.5, 0.2), "{}");
  write_trajectory(folder / "fast.h5", swaying(51, 48, 24, 0.7, 0.2), "{}");
  const json out = evaluate_trajectory(folder / "fast.h5", folder / "truth.h5");
  EXPECT_NEAR(out["tip_in_truth"]["dominant_frequency"].get<double>(), 0.5, 0.005);
  EXPECT_NEAR(out["frequency_error"].get<double>(), 0.4, 0.01);
  // A still prediction has no frequency, and all of the error.
  write_trajectory(folder / "still.h5", swaying(51, 48, 24, 0.5, 0), "{}");
  const json still = evaluate_trajectory(folder / "still.h5", folder / "truth.h5");
  EXPECT_TRUE(still["tip"]["dominant_frequency"].is_null());
  EXPECT_EQ(still["frequency_error"], 1);
  EXPECT_TRUE(evaluate_trajectory(folder / "truth.h5", folder / "still.h5")["frequency_error"].is_null());
  // Of one that is too slow for the record it is known how wrong it is at least.
  write_trajectory(folder / "slow.h5", swaying(51, 48, 24, 0.15, 0.2), "{}");
  const json slow = evaluate_trajectory(folder / "slow.h5", folder / "truth.h5");
  EXPECT_TRUE(slow["tip"]["dominant_frequency"].is_null());
  EXPECT_NEAR(slow["frequency_error"].get<double>(), 1 - slow["tip"]["frequency_below"].get<double>() / 0.5, 0.01);
  EXPECT_GT(slow["frequency_error"], 0.2);
  EXPECT_LT(slow["frequency_error"], 0.7);
  // What hardly moves does not pass for slow.
  write_trajectory(folder / "faint.h5", swaying(51, 48, 24, 0.15, 0.002), "{}");
  EXPECT_EQ(evaluate_trajectory(folder / "faint.h5", folder / "truth.h5")["frequency_error"], 1);
}

TEST(EvaluateTrajectory, TheTipOfWhatHangsIsItsLowerEnd) {
  const TemporaryFolder folder;
  write_trajectory(folder / "hangs.h5", swaying(101, 90, 30, 1.5, 0.2, true), "{}");
  write_trajectory(folder / "stands.h5", swaying(101, 90, 30, 1.5, 0.2), "{}");
  const json hangs = evaluate_trajectory(folder / "hangs.h5", folder / "hangs.h5"),
             stands = evaluate_trajectory(folder / "stands.h5", folder / "stands.h5");
  EXPECT_NEAR(hangs["tip"]["peak"].get<double>(), stands["tip"]["peak"].get<double>(), 1e-6);
  EXPECT_EQ(hangs["frequency_error"], 0);
}

TEST(EvaluateTrajectory, UpIsThatOfThePredictionWhereTheTruthDoesNotSayIt) {
  const TemporaryFolder folder;
  // Wider than high, so that the largest extent is not the height.
  TrajectoryFile rod = swaying(51, 48, 24, 2, 0.2);
  for (auto& frame : rod.frames) {
    frame.position.push_back(Vec3f(-3, 0, 0));
    frame.velocity.push_back(Vec3f::Zero());
    frame.F.push_back(Mat3f::Identity());
  }
  write_trajectory(folder / "up.h5", rod, "{}");
  rod.up = Vec3d::Zero();
  write_trajectory(folder / "unknown.h5", rod, "{}");
  EXPECT_NEAR(evaluate_trajectory(folder / "up.h5", folder / "unknown.h5")["height"].get<double>(), 1, 1e-6);
  EXPECT_NEAR(evaluate_trajectory(folder / "unknown.h5", folder / "unknown.h5")["height"].get<double>(), 3, 1e-6);
}

TEST(EvaluateTrajectory, AFrameRateThatIsNoMultipleMakesNoErrorOfItsOwn) {
  const TemporaryFolder folder;
  for (const double metres : {1.0, 0.25}) {
    TrajectoryFile truth = swaying(51, 48, 24, 2, 0.2), slow = swaying(51, 21, 10, 2, 0.2);
    for (TrajectoryFile* t : {&truth, &slow}) {
      t->metres_per_unit = metres;
      for (auto& frame : t->frames)
        for (Vec3f& x : frame.position) x /= static_cast<float>(metres);
    }
    write_trajectory(folder / "truth.h5", truth, "{}");
    write_trajectory(folder / "slow.h5", slow, "{}");
    const json out = evaluate_trajectory(folder / "slow.h5", folder / "truth.h5");
    EXPECT_LT(out["relative_error"].get<double>(), 0.02) << metres;  // linear between frames: 0.15
    EXPECT_NEAR(out["height"].get<double>(), 1 / metres, 1e-6);
  }
}

TEST(EvaluateTrajectory, NeedsFramesAndOverlap) {
  const TemporaryFolder folder;
  write_trajectory(folder / "truth.h5", swaying(11, 30, 30, 2, 0.1), "{}");
  write_trajectory(folder / "one.h5", swaying(11, 1, 30, 2, 0.1), "{}");
  expect_error(Failure::kInput, {"one.h5", "fewer than 2 frames"},
               [&] { evaluate_trajectory(folder / "one.h5", folder / "truth.h5"); });
  write_trajectory(folder / "tiny.h5", swaying(11, 2, 3000, 2, 0.1), "{}");
  expect_error(Failure::kInput, {"tiny.h5", "overlap"},
               [&] { evaluate_trajectory(folder / "tiny.h5", folder / "truth.h5"); });
  expect_error(Failure::kInput, {"does not exist"},
               [&] { evaluate_trajectory(folder / "none.h5", folder / "truth.h5"); });
}

}  // namespace
}  // namespace pliant
