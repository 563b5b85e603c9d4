// The whole path on a small demo scene: one command makes a clip of the flower moving; repeating it does no work;
// the truth is not looked at; wrong input ends with the right exit code and leaves nothing half done.

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "gaussians/io/files/files.h"
#include "tests/app/run_pliant.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class PipelineTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::temp_directory_path() / ("pliant_pipeline_" + std::to_string(getpid()));
    fs::remove_all(folder);
    fs::create_directories(folder);
    ASSERT_EQ(run_pliant({"demo", "--out", (folder / "scene").string(), "--gaussians", "9000", "--photos", "12",
                          "--width", "160", "--height", "120", "--no-video", "--quiet"}),
              0);
    fs::remove_all(folder / "scene" / "truth");
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static std::vector<std::string> run_command(const std::string& out) {
    return {"run",
            (folder / "scene").string(),
            "--out",
            (folder / out).string(),
            "--seed.particles",
            "1000",
            "--duration",
            "1.5",
            "--simulate.fps",
            "12",
            "--segment.iterations",
            "60",
            "--quiet"};
  }

  static fs::path folder;
};
fs::path PipelineTest::folder;

TEST_F(PipelineTest, FromSceneToClipOfAFlowerThatMovesAndComesBack) {
  ASSERT_EQ(run_pliant(run_command("run")), 0);
  const fs::path run = folder / "run";
  for (const char* file : {"clip.mp4", "clip_orbit.mp4", "report.html", "run.json", "objects.json", "objects.png",
                           "segmentation.h5", "background.ply", "background_repaired.ply", "interactions.json"})
    EXPECT_TRUE(fs::exists(run / file)) << file;
  const json manifest = json::parse(read_text(run / "run.json"));
  const json motion = manifest["stages"]["simulate"]["summary"]["motion"];
  EXPECT_GE(motion["tip_peak"].get<double>(), 0.05);
  EXPECT_LE(motion["tip_peak"].get<double>(), 0.40);
  EXPECT_LE(motion["tip_drift_before"].get<double>(), 0.005);
  EXPECT_EQ(manifest["stages"]["extract"]["summary"]["name"], "flower");

  // Repeating the command skips every stage and changes no file.
  const std::string clip = sha256_of_file(run / "clip.mp4"), record = read_text(run / "run.json");
  ASSERT_EQ(run_pliant(run_command("run")), 0);
  EXPECT_EQ(sha256_of_file(run / "clip.mp4"), clip);
  EXPECT_EQ(read_text(run / "run.json"), record);

  // Another material is simulated and rendered; what comes before stays.
  std::vector<std::string> other = run_command("run");
  other.insert(other.end(), {"--density", "123"});
  EXPECT_EQ(run_pliant(other), 0);
  EXPECT_NE(sha256_of_file(run / "clip.mp4"), clip);
  const json again = json::parse(read_text(run / "run.json"));
  for (const char* stage : {"segment", "extract", "repair", "seed"})
    EXPECT_EQ(again["stages"][stage], manifest["stages"][stage]) << stage;
  EXPECT_NEAR(again["stages"]["simulate"]["summary"]["mass_kg"].get<double>() /
                  manifest["stages"]["simulate"]["summary"]["mass_kg"].get<double>(),
              123 / manifest["stages"]["simulate"]["found"]["material"]["density"].get<double>(), 1e-4);

  // A page that cannot be as small as it was asked to be takes nothing else along.
  fs::remove(run / "report.html");
  other.insert(other.end(), {"--html-size", "1k"});
  EXPECT_EQ(run_pliant(other), 2);
  EXPECT_TRUE(fs::exists(run / "report.html"));
  EXPECT_TRUE(fs::exists(run / "clip.html")) << "the earlier one, of the same motion";
}

TEST_F(PipelineTest, MistakesOfTheCommandLineExitWithTwo) {
  const std::string scene = (folder / "scene").string(), out = (folder / "wrong").string();
  EXPECT_EQ(run_pliant({"run", scene, "--out", out, "--young", "-5", "--quiet"}), 2);
  EXPECT_EQ(run_pliant({"run", scene, "--out", out, "--poisson", "0.5", "--quiet"}), 2);
  EXPECT_EQ(run_pliant({"run", scene, "--out", out, "--yuong", "5"}), 2);
  EXPECT_EQ(run_pliant({"run", scene, "--out", out, "--aabb", "1,2,3"}), 2);
  EXPECT_EQ(run_pliant({"segment", scene, "--out", out, "--box", "nowhere,1,1,50,50", "--quiet"}), 2);
  EXPECT_EQ(run_pliant({"segment", scene, "--out", out, "--click", "0,5", "--quiet"}), 2);
  EXPECT_EQ(run_pliant({"segment", scene, "--out", out, "--stroke", "fg,0,1,1,2", "--quiet"}), 2);
  EXPECT_EQ(run_pliant({"extract", scene, "--object", "flower"}), 2);
  EXPECT_EQ(run_pliant({}), 2);
  EXPECT_EQ(run_pliant({"--version"}), 0);
}

TEST_F(PipelineTest, ADemoThatFailsLeavesNoLock) {
  // The folder's name leaves room for .lock, but not for .partial.
  const fs::path out = folder / std::string(249, 'a');
  EXPECT_NE(run_pliant({"demo", "--out", out.string(), "--no-video", "--quiet"}), 0);
  EXPECT_FALSE(fs::exists(out.string() + ".lock"));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(PipelineTest, ADemoThatIsInterruptedExitsWith130AndLeavesNothing) {
  const fs::path out = folder / "interrupted", partial = out.string() + ".partial";
  std::atomic<bool> ended = false;
  std::thread user([&] {
    while (!ended && !fs::exists(partial / "photos/view_000.png")) std::this_thread::yield();
    if (!ended) kill(getpid(), SIGINT);
  });
  EXPECT_EQ(run_pliant({"demo", "--out", out.string(), "--photos", "300", "--width", "160", "--height", "120",
                        "--no-video", "--quiet"}),
            130);
  ended = true;
  user.join();
  for (const std::string name : {"", ".lock", ".partial"}) EXPECT_FALSE(fs::exists(out.string() + name)) << name;
  EXPECT_EQ(run_pliant({"--version"}), 0);
}

// What cannot be rendered or done to the object is refused before anything is made.
TEST_F(PipelineTest, WhatComesLastIsCheckedFirst) {
  const fs::path run = folder / "checked", script = folder / "shove.json", cameras = folder / "path.json";
  write_text(script, R"([{"type": "shove"}])");
  write_text(cameras, "[]");
  const std::vector<std::vector<std::string>> wrong = {
      {"--size", "1920"},
      {"--render.camera", "nosuch"},
      {"--render.cameras", cameras.string(), "--render.camera", "view_000"},
      {"--render.turntable", "--render.no-orbit"},
      {"--interactions", script.string()}};
  for (const std::vector<std::string>& words : wrong) {
    std::vector<std::string> command = run_command("checked");
    command.insert(command.end(), words.begin(), words.end());
    EXPECT_EQ(run_pliant(command), 2) << words[0];
    EXPECT_FALSE(fs::exists(run / "segmentation.h5")) << words[0];
  }
  std::vector<std::string> command = run_command("checked");
  command.insert(command.end(), {"--render.cameras", (folder / "nosuch.json").string()});
  EXPECT_EQ(run_pliant(command), 1);
  EXPECT_FALSE(fs::exists(run / "segmentation.h5"));
}

TEST_F(PipelineTest, AMissingFileExitsWithOne) {
  EXPECT_EQ(run_pliant({"info", (folder / "absent.ply").string()}), 1);
  write_text(folder / "lying.ply",
             "ply\nformat binary_little_endian 1.0\nelement vertex 999999999\nproperty float x\nend_header\n");
  EXPECT_EQ(run_pliant({"convert", (folder / "lying.ply").string(), (folder / "out.ply").string()}), 1);
  EXPECT_FALSE(fs::exists(folder / "out.ply"));
}

}  // namespace
}  // namespace pliant
