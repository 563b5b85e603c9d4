// A start of motion from a file: `simulate --velocity`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/simulate/simulate_stage.h"
#include "app/simulate/simulated_body.h"
#include "app/store/velocity.h"
#include "tests/app/beam_scene.h"
#include "tests/app/run_pliant.h"
#include "tests/app/simulate/bar_run.h"
#include "tests/energy_decay.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using namespace fixture;
using nlohmann::json;

/// The beam swings up, more the farther it is from where it is held; places in scene units.
VelocityFile swing(double whole_damping_time) {
  VelocityFile v;
  for (int i = 0; i <= 40; ++i)
    for (const float y : {0.0f, 0.14f})
      for (const float z : {1.0f, 1.14f}) {
        const float s = std::max(0.0f, (0.02f * i - 0.1f) / 0.7f);
        v.position.push_back(Vec3f(0.02f * i, y, z));
        v.velocity.push_back(Vec3f(0, 0, 0.4f * s * s));
        v.displacement.push_back(Vec3f::Zero());
        v.F.push_back(Mat3f::Identity());
        v.C.push_back(Mat3f::Zero());
      }
  v.damping_time = 2;
  v.whole_damping_time = whole_damping_time;
  v.source = "made";
  return v;
}

TEST(SimulateStart, DiesAwayAsFastAsItsFileSaysOnAnyGrid) {
  constexpr double kYoung = 1e6, kWhole = 0.5;
  const TemporaryFolder folder;
  make_beam_scene(folder / "scene");
  write_velocity(folder / "own.h5", swing(kWhole), "{}");
  write_velocity(folder / "drag.h5", swing(0), "{}");
  double drag[2];
  for (const int particles : {300, 800}) {
    const std::string out = (folder / ("run_" + std::to_string(particles))).string();
    ASSERT_EQ(
        run_quietly({"segment", (folder / "scene").string(), "--out", out, "--aabb", "-0.1,-0.1,0.9,0.9,0.3,1.3"}), 0);
    ASSERT_EQ(run_quietly({"extract", out, "--object", "object"}), 0);
    ASSERT_EQ(run_quietly({"seed", out, "--particles", std::to_string(particles), "--no-pin-contact"}), 0);
    const auto simulated = [&](const char* file, std::vector<std::string> more = {}) {
      std::vector<std::string> words = {
          "simulate", out, "--velocity", (folder / file).string(), "--young", std::to_string(kYoung), "--fps", "120"};
      words.insert(words.end(), more.begin(), more.end());
      EXPECT_EQ(run_quietly(words), 0);
      return json::parse(read_text(fs::path(out) / "run.json"))["stages"]["simulate"]["summary"]["damping_time_s"]
          .get<double>();
    };
    drag[particles > 300] = simulated("own.h5", {"--duration", "0.6"});
    const fs::path object = fs::path(out) / object_folder(RunDirectory::open(out));
    EXPECT_NEAR(decay_rate(
                    object, [](const Vec3f&) { return kYoung; }, 0.35, 900) *
                    kWhole,
                1, 0.1)
        << particles;
    // The drag of a file that says nothing of the whole, and one that the user gives, are taken as they are.
    if (particles > 300) continue;
    EXPECT_EQ(simulated("drag.h5", {"--duration", "0.02"}), 2);
    EXPECT_EQ(simulated("own.h5", {"--duration", "0.02", "--damping-time", "3"}), 3);
  }
  EXPECT_GT(drag[0], drag[1]);
  EXPECT_GT(drag[1], kWhole);
}

class SimulateBarStart : public BarRun {};

TEST_F(SimulateBarStart, ASimulationThatFailsLeavesThePreviousOneWhole) {
  make(true);
  ASSERT_EQ(simulate({"--young", "1e5", "--duration", "0.05", "--interactions", script(json::array())}), 0);
  const std::vector<fs::path> files = {object() / "material.h5", object() / "trajectory.h5",
                                       folder_ / "run/interactions.json"};
  std::vector<std::string> before;
  for (const fs::path& file : files) before.push_back(read_text(file));
  EXPECT_EQ(simulate({"--young", "2e5", "--interactions", script(json::array({json{{"type", "shove"}}}))}), 2);
  for (size_t k = 0; k < files.size(); ++k) EXPECT_EQ(read_text(files[k]), before[k]) << files[k];
  EXPECT_EQ(summary()["session"]["uniform"]["young"], 1e5);
}

TEST_F(SimulateBarStart, AFitThatAnUnfinishedOneIsToReplaceIsNotPassedOverUnasked) {
  make(true);
  json record = json::parse(read_text(folder_ / "run/run.json"));
  const json fit = finished_stage(json::object(), {"fit/results.json", "objects/1_bar/material.h5"});
  record["begun"]["fit"] = {{"outputs", fit["outputs"]},
                            {"replaced", {{"record", fit}, {"moved", json::array()}, {"written", json::array()}}}};
  write_text(folder_ / "run/run.json", record.dump());
  const RunDirectory run = RunDirectory::open(folder_ / "run");
  Scene scene = load_run_scene(run);
  scene.settings.material.young = 1e5;
  scene.settings.material.poisson = 0.3;
  scene.settings.material.density = 500;
  SimulateStage stage;
  expect_error(Failure::kUsage, {"unfinished", "--no-fit"}, [&] { inputs_of(run, scene, stage); });
  stage.use_fit = false;
  EXPECT_NO_THROW(inputs_of(run, scene, stage));
  stage.use_fit = true;
  stage.material.young = 2e5;
  EXPECT_NO_THROW(inputs_of(run, scene, stage));
}

// A solved rest shape is simulated on the Eulerian grid: the start dies away there as in a captured shape.
TEST_F(SimulateBarStart, KeepsItsDampingAndItsDeformationInASolvedRestShape) {
  make(true);
  VelocityFile start;
  const Mat3f turn = Eigen::AngleAxisf(0.02f, Vec3f::UnitX()).toRotationMatrix();
  for (const Vec3f& x : particles_.driving_position) {
    const float s = std::max(0.0f, (x.x() - 0.05f) / 0.27f);
    start.position.push_back(x);
    start.velocity.push_back(Vec3f(0, 0.4f * s * s, 0));
    start.displacement.push_back(Vec3f::Zero());
    start.F.push_back(turn);
    start.C.push_back(Mat3f::Zero());
  }
  start.damping_time = 2;
  start.whole_damping_time = 0.5;
  start.source = "made";
  write_velocity(folder_ / "start.h5", start, "{}");
  std::vector<double> drag;
  for (const auto& [option, value] : {std::pair("--solver", "eulerian"), std::pair("--rest-shape", "solve")}) {
    ASSERT_EQ(
        simulate({"--young", "2e6", "--duration", "0.1", "--velocity", (folder_ / "start.h5").string(), option, value}),
        0);
    drag.push_back(summary()["damping_time_s"]);
    const TrajectoryFile::Frame first = motion().frames.at(0);
    for (size_t i = 0; i < first.F.size(); ++i) {
      ASSERT_LT((first.F[i] - turn).norm(), 1e-5f) << value;
      ASSERT_EQ(first.velocity[i], start.velocity[i]) << value;
    }
  }
  EXPECT_GT(drag[0], 0.5);
  EXPECT_EQ(drag[0], drag[1]);
}

TEST(SimulateStart, AFileThatSaysNoTimeIsRefused) {
  const TemporaryFolder folder;
  write_velocity(folder / "good.h5", swing(0.5), "{}");
  EXPECT_EQ(read_velocity(folder / "good.h5").whole_damping_time, 0.5);
  write_velocity(folder / "bad.h5", swing(INFINITY), "{}");
  EXPECT_THROW(read_velocity(folder / "bad.h5"), Error);
}

}  // namespace
}  // namespace pliant
