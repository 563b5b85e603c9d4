// The whole path on a small demo scene: one command makes a clip of the flower moving; repeating it does no work;
// the truth is not looked at; wrong input ends with the right exit code and leaves nothing half done.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

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

TEST_F(PipelineTest, AMissingFileExitsWithOne) {
  EXPECT_EQ(run_pliant({"info", (folder / "absent.ply").string()}), 1);
  write_text(folder / "lying.ply",
             "ply\nformat binary_little_endian 1.0\nelement vertex 999999999\nproperty float x\nend_header\n");
  EXPECT_EQ(run_pliant({"convert", (folder / "lying.ply").string(), (folder / "out.ply").string()}), 1);
  EXPECT_FALSE(fs::exists(folder / "out.ply"));
}

}  // namespace
}  // namespace pliant
