// Motions with known frequency, damping and amplitude, as values, as videos and as trajectories.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/evaluate/vibration.h"
#include "app/store/trajectory.h"
#include "gaussians/base/random.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

TEST(FitOscillation, FrequencyDecayAndAmplitudeOfAClosedFormAreFound) {
  for (const double frequency : {0.7, 1.9, 6.3})
    for (const double decay : {0.0, 0.6, 2.5}) {
      std::vector<double> values;
      for (int i = 0; i < 75; ++i) {
        const double t = i / 30.0;
        values.push_back(0.3 - 0.1 * t + 1.7 * std::exp(-decay * t) * std::sin(2 * M_PI * frequency * t + 0.4) +
                         0.01 * Random(3, i).normal());
      }
      const DampedOscillation found = fit_oscillation(values, 30);
      EXPECT_NEAR(found.frequency / frequency, 1, 0.01) << frequency << " " << decay;
      EXPECT_NEAR(found.decay, decay, 0.02 + 0.03 * decay);
      EXPECT_NEAR(found.amplitude / 1.7, 1, 0.05);
      EXPECT_GT(found.explained, 0.99);
    }
}

TEST(FitOscillation, AMotionThatDiesOutEarlyInTheRecordIsFound) {
  for (const double seconds : {4.0, 10.0})
    for (const double frequency : {1.5, 2.0, 3.0, 5.0})
      for (const double decay : {0.0, 1.0, 3.0, 4.5, 6.0, 9.0})
        for (const double noise : {0.0, 1e-3}) {
          std::vector<double> values;
          for (int i = 0; i < 30 * seconds; ++i) {
            const double t = i / 30.0;
            values.push_back(0.3 - 0.1 * t + 1.7 * std::exp(-decay * t) * std::sin(2 * M_PI * frequency * t + 0.4) +
                             noise * Random(5, i).normal());
          }
          const DampedOscillation found = fit_oscillation(values, 30);
          const double exact = noise > 0 ? 1 : 1e-4;
          EXPECT_NEAR(found.frequency / frequency, 1, 0.01 * exact) << seconds << " " << decay;
          EXPECT_NEAR(found.decay, decay, exact * (0.01 + 0.02 * decay)) << seconds << " " << frequency;
          EXPECT_NEAR(found.amplitude / 1.7, 1, 0.02 * exact) << seconds << " " << frequency << " " << decay;
        }
}

TEST(FitOscillation, ADecayAsFastAsTheOscillationIsFound) {
  // The second swing has 0.2 % of the first.
  for (const double periods : {2.0, 6.0, 15.0}) {
    std::vector<double> values;
    const double rate = 40, frequency = periods * rate / 250, decay = 2 * M_PI * frequency;
    for (int i = 0; i < 250; ++i)
      values.push_back(2 + 0.4 * std::exp(-decay * i / rate) * std::cos(2 * M_PI * frequency * i / rate));
    const DampedOscillation found = fit_oscillation(values, rate);
    EXPECT_NEAR(found.frequency / frequency, 1, 1e-4) << periods;
    EXPECT_NEAR(found.decay / decay, 1, 1e-4) << periods;
  }
}

TEST(FitOscillation, ValuesThatCreepBackWithoutASwingHaveNoFrequency) {
  for (const double rate : {1.0, 3.0, 6.0, 25.0}) {
    std::vector<double> simple, from_rest;
    for (int i = 0; i < 120; ++i) {
      const double e = std::exp(-rate * i / 30.0);
      simple.push_back(e);
      from_rest.push_back(2 * e - e * e);
    }
    EXPECT_EQ(fit_oscillation(simple, 30).frequency, 0) << rate;
    EXPECT_EQ(fit_oscillation(from_rest, 30).frequency, 0) << rate;
  }
}

TEST(FitOscillation, ASwingOfLessThanHalfAPeriodInTheRecordIsKnownToBeSlower) {
  for (const double periods : {0.2, 0.3, 0.4}) {
    std::vector<double> values;
    for (int i = 0; i < 60; ++i) values.push_back(0.4 + std::cos(2 * M_PI * periods * i / 60.0));
    const DampedOscillation found = fit_oscillation(values, 30);
    EXPECT_EQ(found.frequency, 0) << periods;
    EXPECT_NEAR(found.slower_than, 0.25, 1e-12) << periods;  // of two seconds
  }
  EXPECT_EQ(fit_oscillation(std::vector<double>(40, 2.0), 30).slower_than, 0);
}

TEST(FitOscillation, ValuesThatDoNotOscillateHaveNoFrequency) {
  EXPECT_EQ(fit_oscillation(std::vector<double>(40, 2.0), 30).frequency, 0);
  EXPECT_EQ(fit_oscillation({1, 2, 1, 2}, 30).frequency, 0);
}

TEST(DescribeVibration, SmallSwingsAreMeasuredOnTheirOwn) {
  // A pendulum that is slower by a tenth at its largest swing.
  PointMotion motion;
  motion.rate = 30;
  motion.dims = 1;
  motion.weight = {1};
  double phase = 0;
  for (int i = 0; i < 150; ++i) {
    const double amplitude = std::exp(-1.2 * i / 30.0);
    motion.displacement.push_back({20 * amplitude * std::cos(phase)});
    phase += 2 * M_PI * 3.2 * (1 - 0.1 * amplitude * amplitude) / 30;
  }
  int first = -1;
  const Vibration found = describe_vibration(motion, first);
  EXPECT_LT(found.oscillation.frequency, 0.98 * 3.2);
  EXPECT_NEAR(found.small.frequency / 3.2, 1, 0.01);
  // One that does not die away has no small swings.
  for (int i = 0; i < 150; ++i) motion.displacement[i][0] = std::cos(0.6 * i);
  first = -1;
  EXPECT_EQ(describe_vibration(motion, first).small.frequency, 0);
}

/// A smooth texture that never repeats, of one of two kinds.
float texture(double x, double y, int kind) {
  double sum = 0, total = 0;
  for (int k = 0; k < 6; ++k) {
    Random random(20 + kind, k);
    const double angle = 2 * M_PI * random.uniform(), length = 9 + 18 * random.uniform(),
                 phase = 2 * M_PI * random.uniform();
    sum += std::sin(2 * M_PI * (x * std::cos(angle) + y * std::sin(angle)) / length + phase);
    total += 1;
  }
  return static_cast<float>(0.5 + 0.45 * sum / total * 1.6);
}

struct Swing {
  double frequency = 1.6, decay = 0.5, amplitude = 6;  // Hz, 1/s, px
  double fps = 30, release = 0;                        // s, held at the amplitude until then
  int frames = 40, width = 96, height = 72;

  double at(double time) const {
    const double t = std::max(0.0, time - release);
    return amplitude * std::exp(-decay * t) * std::cos(2 * M_PI * frequency * t);
  }
  bool stem = false;
  /// A textured disc that swings sideways before a textured wall, or a stem that bends.
  ImageF frame(int f) const {
    ImageF picture(width, height, 3);
    const double shift = at(f / fps);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double height_share = 1 - (y + 0.5) / height, bend = stem ? height_share * height_share : 1;
        const double u = x + 0.5 - 0.5 * width - bend * shift, v = y + 0.5 - 0.5 * height;
        const double edge = std::clamp(stem ? 9 - std::abs(u) + 0.5 : 20 - std::hypot(u, v) + 0.5, 0.0, 1.0);
        for (int c = 0; c < 3; ++c)
          picture(x, y, c) = static_cast<float>(edge * std::clamp(texture(u + 7 * c, v, 0), 0.f, 1.f) +
                                                (1 - edge) * 0.6 * std::clamp(texture(x, y + 5 * c, 1), 0.f, 1.f));
      }
    return picture;
  }
  void write_folder(const std::filesystem::path& folder) const {
    for (int f = 0; f < frames; ++f) write_image(folder / ("f" + std::to_string(f) + ".png"), frame(f));
  }
  void write_video(const std::filesystem::path& file) const {
    VideoWriter writer(file, fps, width, height);
    for (int f = 0; f < frames; ++f) writer.write(frame(f));
    writer.close();
  }
};

TEST(EvaluateMotion, OfAFilmedDiscGivesItsFrequencyDampingAndAmplitude) {
  const TemporaryFolder folder;
  Swing truth, other;
  truth.write_video(folder / "truth.mp4");
  other.frequency = 1.84;
  other.decay = 1.0;
  other.amplitude = 4;
  other.write_folder(folder / "other");
  MotionScore score;
  score.fps = 30;
  const json out = evaluate_motion(folder / "other", folder / "truth.mp4", score);
  EXPECT_NEAR(out["truth"]["frequency_hz"].get<double>(), 1.6, 0.016);
  EXPECT_NEAR(out["prediction"]["frequency_hz"].get<double>(), 1.84, 0.02);
  EXPECT_NEAR(out["truth"]["damping_time_s"].get<double>(), 2, 0.1);
  EXPECT_NEAR(out["prediction"]["log_decrement"].get<double>(), 1 / 1.84, 0.03);
  // From the first peak to the next one on the other side.
  EXPECT_NEAR(out["truth"]["amplitude_px"].get<double>(), 0.5 * (truth.at(0) - truth.at(0.5 / 1.6)), 0.25);
  EXPECT_NEAR(out["frequency_error"].get<double>(), 0.15, 0.02);
  EXPECT_NEAR(out["damping_error"].get<double>(), 1, 0.1);
  EXPECT_NEAR(out["amplitude_error"].get<double>(), 0.37, 0.06);
  EXPECT_GT(out["flow_error"].get<double>(), 0.3);
  EXPECT_GT(out["truth"]["explained"].get<double>(), 0.98);
}

TEST(EvaluateMotion, OfItselfIsWithoutErrorAndAStillVideoHasNoFrequency) {
  const TemporaryFolder folder;
  Swing truth;
  truth.frames = 24;
  truth.write_folder(folder / "truth");
  MotionScore score;
  score.fps = 30;
  json out = evaluate_motion(folder / "truth", folder / "truth", score);
  EXPECT_EQ(out["frequency_error"], 0);
  EXPECT_EQ(out["flow_error_px"], 0);
  Swing still = truth;
  still.amplitude = 0;
  still.write_folder(folder / "still");
  out = evaluate_motion(folder / "still", folder / "truth", score);
  EXPECT_TRUE(out["prediction"]["frequency_hz"].is_null());
  EXPECT_NEAR(out["amplitude_error"].get<double>(), 1, 0.05);
  EXPECT_GT(out["flow_error"].get<double>(), 0.7);
  expect_error(Failure::kInput, {"still", "shows no motion"},
               [&] { evaluate_motion(folder / "truth", folder / "still", score); });
  // The command line fails where an assertion does.
  const std::vector<std::string> command = {"evaluate",
                                            "motion",
                                            (folder / "truth").string(),
                                            (folder / "truth").string(),
                                            "--fps",
                                            "30",
                                            "--out",
                                            (folder / "out.json").string(),
                                            "--json",
                                            "--assert"};
  auto with = command;
  with.push_back("frequency_error<=0.02");
  EXPECT_EQ(run_quietly(with), 0);
  with.back() = "truth.frequency_hz>=3";
  EXPECT_EQ(run_quietly(with), 1);
}

TEST(EvaluateMotion, APredictionOfAnotherSizeIsScaledWithAWarning) {
  const TemporaryFolder folder;
  Swing swing;
  swing.frames = 24;
  swing.write_folder(folder / "truth");
  swing.width /= 2;
  swing.height /= 2;
  swing.write_folder(folder / "small");
  MotionScore score;
  score.fps = 30;
  const auto says = [&](const char* prediction) {
    return evaluate_motion(folder / prediction, folder / "truth", score)["warnings"].dump().find(
               "small is 48 x 36 and is compared at 96 x 72") != std::string::npos;
  };
  EXPECT_TRUE(says("small"));
  EXPECT_FALSE(says("truth"));
}

TEST(EvaluateMotion, TheFrameRateOfAVideoDoesNotChangeItsMotion) {
  const TemporaryFolder folder;
  Swing swing;
  swing.stem = true;
  swing.frequency = 2;
  swing.amplitude = 24;
  swing.write_video(folder / "30.mp4");
  swing.fps = 24;
  swing.frames = 32;
  swing.write_video(folder / "24.mp4");
  const json out = evaluate_motion(folder / "24.mp4", folder / "30.mp4");
  EXPECT_LT(out["amplitude_error"].get<double>(), 0.1);
  EXPECT_LT(out["frequency_error"].get<double>(), 0.005);
  EXPECT_LT(out["flow_error"].get<double>(), 0.17);
  EXPECT_EQ(out["delay_s"], 0);
  EXPECT_EQ(out["truth"]["fps"], 30);
  EXPECT_EQ(out["prediction"]["fps"], 24);
}

TEST(EvaluateMotion, AClipThatBeginsAtTheReleaseIsAheadOfAVideoThatBeginsEarlier) {
  const TemporaryFolder folder;
  Swing clip;
  clip.width = 80;
  clip.height = 56;
  clip.frames = 30;
  Swing video = clip;
  video.release = 0.4;
  video.frames += 12;
  clip.write_folder(folder / "clip");
  video.write_folder(folder / "video");
  MotionScore score;
  score.fps = 30;
  const json out = evaluate_motion(folder / "clip", folder / "video", score);
  EXPECT_NEAR(out["delay_s"].get<double>(), -0.4, 1e-9);
  EXPECT_GT(out["flow_error"].get<double>(), 0.8);
  EXPECT_LT(out["flow_error_without_delay"].get<double>(), 0.05);
  EXPECT_LT(out["amplitude_error"].get<double>(), 0.05);
}

TEST(EvaluateMotion, UselessInputIsRefused) {
  const TemporaryFolder folder;
  Swing swing;
  swing.frames = 3;
  swing.write_folder(folder / "a");
  MotionScore score;
  expect_error(Failure::kInput, {"fps"}, [&] { evaluate_motion(folder / "a", folder / "a", score); });
  score.fps = 30;
  score.free_from = 1;
  expect_error(Failure::kUsage, {"--free-from", "1 s", "0.1 s", "8 frames"},
               [&] { evaluate_motion(folder / "a", folder / "a", score); });
  score.free_from = -1;
  expect_error(Failure::kInput, {"none", "does not exist"},
               [&] { evaluate_motion(folder / "none", folder / "a", score); });
  swing.width = 48;
  swing.write_folder(folder / "narrow");
  expect_error(Failure::kInput, {"narrow"}, [&] { evaluate_motion(folder / "narrow", folder / "a", score); });
  folder.file("lie.mp4", "no video");
  expect_error(Failure::kUsage, {"--fps", "videos"},
               [&] { evaluate_motion(folder / "lie.mp4", folder / "lie.mp4", score); });
  expect_error(Failure::kInput, {"lie.mp4"}, [&] { evaluate_motion(folder / "lie.mp4", folder / "a", score); });
  folder.file("t.h5", "no trajectory");
  expect_error(Failure::kInput, {"trajectory"}, [&] { evaluate_motion(folder / "t.h5", folder / "a", score); });
}

TEST(EvaluateMotion, BothClipsLastUntilTheFitOfTheFreeMotion) {
  const TemporaryFolder folder;
  Swing swing;
  swing.write_folder(folder / "truth");
  swing.frames = 20;
  swing.write_folder(folder / "brief");
  MotionScore score;
  score.fps = 30;
  score.free_from = 0.8;
  expect_error(Failure::kUsage, {"--free-from", "0.8 s", "prediction", "0.6667 s", "at most 0.4"},
               [&] { evaluate_motion(folder / "brief", folder / "truth", score); });
  expect_error(Failure::kUsage, {"--free-from", "0.8 s", "truth", "0.6667 s", "at most 0.4"},
               [&] { evaluate_motion(folder / "truth", folder / "brief", score); });
  score.free_from = 0.4;
  EXPECT_EQ(evaluate_motion(folder / "brief", folder / "truth", score)["free_from_by"], "--free-from");
}

TEST(EvaluateMotion, TheFreeMotionCountsFromTheBeginOfTheComparedPart) {
  const TemporaryFolder folder;
  // Held for 0.8 s of the file.
  Swing swing;
  swing.release = 0.8;
  swing.frames = 54;
  swing.write_folder(folder / "clip");
  MotionScore score;
  score.fps = 30;
  score.from = 0.5;
  score.free_from = 0.3;
  const json out = evaluate_motion(folder / "clip", folder / "clip", score);
  EXPECT_NEAR(out["free_from_s"].get<double>(), 0.3, 1e-9);
  EXPECT_NEAR(out["truth"]["frequency_hz"].get<double>(), 1.6, 0.02);
  EXPECT_NEAR(out["truth"]["decay_per_s"].get<double>(), 0.5, 0.05);
}

TEST(EvaluateMotion, OfParticlesGivesTheirFrequencyDampingAndAmplitude) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, double frequency, double decay, double amplitude) {
    TrajectoryFile t;
    t.fps = 30;
    t.up = {0, 0, 1};
    for (int f = 0; f < 90; ++f) {
      TrajectoryFile::Frame frame;
      frame.time = f / 30.0;
      for (int p = 0; p <= 50; ++p) {
        const double z = p / 50.0,
                     sway = amplitude * std::exp(-decay * frame.time) * std::sin(2 * M_PI * frequency * frame.time);
        frame.position.push_back(Vec3d(sway * z, 0.3 * sway * z, z).cast<float>());
      }
      frame.velocity.assign(51, Vec3f::Zero());
      frame.F.assign(51, Mat3f::Identity());
      t.frames.push_back(frame);
    }
    write_trajectory(folder / name, t, "{}");
  };
  write("truth.h5", 1.3, 0.4, 0.1);
  write("ours.h5", 1.43, 0.4, 0.12);
  const json out = evaluate_motion(folder / "ours.h5", folder / "truth.h5");
  EXPECT_NEAR(out["truth"]["frequency_hz"].get<double>(), 1.3, 0.005);
  EXPECT_NEAR(out["truth"]["decay_per_s"].get<double>(), 0.4, 0.01);
  EXPECT_NEAR(out["frequency_error"].get<double>(), 0.1, 0.005);
  EXPECT_NEAR(out["damping_error"].get<double>(), 0, 0.03);
  EXPECT_NEAR(out["amplitude_error"].get<double>(), 0.2, 0.02);
  EXPECT_FALSE(out.contains("flow_error"));
  EXPECT_EQ(out["free_from_by"], "largest motion");
}

}  // namespace
}  // namespace pliant
