// From when on trajectories are free, as their interactions.json tells.

#include "app/evaluate/last_load.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/evaluate/evaluate.h"
#include "app/import/interactions.h"
#include "app/store/trajectory.h"
#include "gaussians/io/files/files.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

/// A rod whose frames lean by `sway_at` of their times [s].
template <class Sway>
std::filesystem::path write_rod(const std::filesystem::path& file, double fps, int frames, const Sway& sway_at) {
  TrajectoryFile t;
  t.fps = fps;
  t.up = {0, 0, 1};
  for (int f = 0; f < frames; ++f) {
    TrajectoryFile::Frame frame;
    frame.time = f / fps;
    const double sway = sway_at(frame.time);
    for (int p = 0; p <= 20; ++p) frame.position.push_back(Vec3d(0.05 * p * sway, 0, 0.05 * p).cast<float>());
    frame.velocity.assign(21, Vec3f::Zero());
    frame.F.assign(21, Mat3f::Identity());
    t.frames.push_back(frame);
  }
  std::filesystem::create_directories(file.parent_path());
  write_trajectory(file, t, "{}");
  return file;
}

constexpr double kOmega = 2 * M_PI * 1.3;

/// A rod that a force holds aside until 0.6 s, about which it swings and comes to rest faster than after it; at 6 s it
/// is let go again.
std::filesystem::path write_pushed_rod(const std::filesystem::path& file, int frames = 90) {
  return write_rod(file, 30, frames, [](double time) {
    const double free = time - (time < 6 - 1e-9 ? 0.6 : 6);
    return free < 0 ? 0.1 * (1 - std::exp(-3 * time) * std::cos(kOmega * time))
                    : 0.1 * std::exp(-0.5 * free) * std::cos(kOmega * free);
  });
}

constexpr const char* kPush = R"([{"type": "point_force", "region": "all", "force": [1, 0, 0], "start": 0.1,
  "duration": 0.5}, {"type": "ground"}, {"type": "pin", "region": {"below": 0}, "duration": 9}])";

TEST(LastLoad, ATrajectoryIsFreeFromTheEndOfItsLoadsOn) {
  const TemporaryFolder folder;
  const auto rod = write_pushed_rod(folder / "beside/trajectory.h5");
  EXPECT_EQ(evaluate_motion(rod, rod)["free_from_by"], "largest motion");
  folder.file("beside/interactions.json", kPush);
  json out = evaluate_motion(rod, rod);
  EXPECT_EQ(out["free_from_by"], "interactions.json");
  EXPECT_NEAR(out["free_from_s"].get<double>(), 0.6, 1e-9);
  EXPECT_NEAR(out["truth"]["damping_time_s"].get<double>(), 2, 0.01);
  MotionScore score;
  score.free_from = 1;
  out = evaluate_motion(rod, rod, score);
  EXPECT_EQ(out["free_from_by"], "--free-from");
  EXPECT_EQ(out["free_from_s"], 1);
  // Loads that leave too little of the motion, or move along a path to its end, tell nothing.
  for (const char* load : {R"([{"type": "gust", "acceleration": [1, 0, 0], "duration": 2.9}])",
                           R"([{"type": "poke", "radius": 0.1, "path": [[0, 0, 0, 0], [4, 1, 0, 0]]}])"}) {
    folder.file("beside/interactions.json", load);
    EXPECT_EQ(evaluate_motion(rod, rod)["free_from_by"], "largest motion") << load;
  }
  folder.file("beside/interactions.json", R"([{"type": "shove"}])");
  expect_error(Failure::kUsage, {"interactions.json", "shove"}, [&] { evaluate_motion(rod, rod); });
}

// The force ends at 0.62 s.  At 24 fps the first free frame is at 0.625 s; at 10 fps that at 0.6 s is nearest to it,
// and not free.
TEST(LastLoad, WhatIsFreeBeginsAfterTheLoadsAtAnyFrameRate) {
  const TemporaryFolder folder;
  const auto sway = [](double time) {
    return time < 0.62 ? 0.5 : 0.1 * std::exp(-0.5 * time) * std::cos(kOmega * time);
  };
  const auto fine = write_rod(folder / "fine/trajectory.h5", 24, 96, sway),
             coarse = write_rod(folder / "coarse/trajectory.h5", 10, 40, sway);
  for (const char* script : {"fine/interactions.json", "coarse/interactions.json"})
    folder.file(script, R"([{"type": "point_force", "region": "all", "force": [1, 0, 0], "start": 0.1,
                             "duration": 0.52}])");
  for (const auto& [ours, truth] : {std::pair{coarse, fine}, std::pair{fine, coarse}}) {
    const json out = evaluate_motion(ours, truth);
    EXPECT_EQ(out["free_from_by"], "interactions.json") << ours;
    for (const char* side : {"truth", "prediction"}) {
      EXPECT_NEAR(out[side]["frequency_hz"].get<double>(), 1.3, 0.002) << ours << side;
      EXPECT_NEAR(out[side]["damping_time_s"].get<double>(), 2, 0.01) << ours << side;
    }
  }
}

TEST(LastLoad, TheFrequencyOfTheTipIsThatAfterTheLoads) {
  const TemporaryFolder folder;
  const auto rod = write_pushed_rod(folder / "beside/trajectory.h5");
  EXPECT_EQ(evaluate_trajectory(rod, rod)["free_from_by"], "largest motion");
  folder.file("beside/interactions.json", kPush);
  const json out = evaluate_trajectory(rod, rod);
  EXPECT_EQ(out["free_from_by"], "interactions.json");
  EXPECT_NEAR(out["free_from_s"].get<double>(), 0.6, 1e-6);
  EXPECT_NEAR(out["tip"]["dominant_frequency"].get<double>(), 1.3, 0.002);
}

TEST(LastLoad, LoadsAfterTheTimeThatBothHaveDoNotCount) {
  const TemporaryFolder folder;
  const auto brief = write_pushed_rod(folder / "brief/trajectory.h5", 90),
             lasting = write_pushed_rod(folder / "lasting/trajectory.h5", 300);
  for (const char* script : {"brief/interactions.json", "lasting/interactions.json"})
    folder.file(script, R"([{"type": "point_force", "region": "all", "force": [1, 0, 0], "start": 0.1, "duration": 0.5},
      {"type": "point_force", "region": "all", "force": [1, 0, 0], "start": 5.5, "duration": 0.5}])");
  for (const auto& [ours, truth] : {std::pair{brief, lasting}, std::pair{lasting, brief}}) {
    const json motion = evaluate_motion(ours, truth), trajectory = evaluate_trajectory(ours, truth);
    for (const json& out : {motion, trajectory}) {
      EXPECT_EQ(out["free_from_by"], "interactions.json") << out["kind"] << ours;
      EXPECT_NEAR(out["free_from_s"].get<double>(), 0.6, 1e-6) << out["kind"] << ours;
      EXPECT_EQ(out["frequency_error"], 0) << out["kind"] << ours;
    }
    for (const char* side : {"truth", "prediction"}) {
      EXPECT_NEAR(motion[side]["frequency_hz"].get<double>(), 1.3, 0.002) << ours;
      EXPECT_NEAR(motion[side]["damping_time_s"].get<double>(), 2, 0.01) << ours;
    }
    EXPECT_NEAR(trajectory["tip"]["dominant_frequency"].get<double>(), 1.3, 0.002) << ours;
  }
}

TEST(LastLoad, TheLoadsOfARunAreThoseOfTheTrajectoryThatWasSimulatedLast) {
  const TemporaryFolder folder;
  folder.file("run/interactions.json", kPush);
  folder.file("run/run.json",
              R"({"stages": {"simulate": {"outputs": ["objects/1_rod/trajectory.h5", "interactions.json"]}}})");
  const auto rod = write_pushed_rod(folder / "run/objects/1_rod/trajectory.h5"),
             other = write_pushed_rod(folder / "run/objects/2_other/trajectory.h5");
  EXPECT_EQ(evaluate_motion(other, other)["free_from_by"], "largest motion");
  const json out = evaluate_motion(rod.parent_path(), other);
  EXPECT_EQ(out["free_from_by"], "interactions.json");
  EXPECT_NEAR(out["prediction"]["damping_time_s"].get<double>(), 2, 0.01);
}

TEST(LastLoad, OfAConfigurationOfPhysGaussianIsUnknown) {
  const TemporaryFolder folder;
  const auto rod = write_pushed_rod(folder / "beside/trajectory.h5");
  const auto script = folder.file("beside/interactions.json", R"({"physgaussian": {"E": 1e5}, "notes": []})");
  EXPECT_EQ(evaluate_motion(rod, rod)["free_from_by"], "largest motion");
  EXPECT_EQ(evaluate_trajectory(rod, rod)["free_from_by"], "largest motion");
  MotionScore score;
  score.free_from = 1;
  EXPECT_EQ(evaluate_motion(rod, rod, score)["free_from_by"], "--free-from");
  expect_error(Failure::kUsage, {"interactions.json", "--physgaussian"},
               [&] { parse_interactions(read_text(script), {}, script.string()); });
}

TEST(LastLoad, IsTheLatestChangeBeforeTheEnd) {
  const TemporaryFolder folder;
  const auto trajectory = folder / "trajectory.h5";
  EXPECT_FALSE(last_load_change(trajectory, 3));
  const auto change = [&](const std::string& rows) {
    folder.file("interactions.json", "[" + rows + "]");
    return last_load_change(trajectory, 3).value();
  };
  EXPECT_EQ(change(""), 0);
  EXPECT_EQ(change(R"({"type": "impulse", "region": "all", "impulse": [1, 0, 0], "start": 0.4})"), 0.4);
  EXPECT_EQ(change(R"({"type": "wind", "wind": [1, 0, 0], "start": 0.7})"), 0.7);
  EXPECT_EQ(change(R"({"type": "pin", "region": "all", "duration": 0.5})"), 0.5);
  EXPECT_EQ(change(R"({"type": "pin", "region": "all", "start": 5})"), 0);
  const std::string poke = R"({"type": "poke", "radius": 1, "start": 0.2, "path": [[0, 0, 0, 0], [1, 1, 0, 0]])";
  EXPECT_EQ(change(poke + "}"), 1.2);
  EXPECT_EQ(change(poke + R"(, "duration": 2})"), 2.2);
  EXPECT_EQ(change(poke + R"(, "duration": 9})"), 1.2);
}

}  // namespace
}  // namespace pliant
