// Commands that are given what is there already leave it as it was, or do again what it no longer holds for.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/commands/command.h"
#include "app/store/segmentation.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/demo/folder_sums.h"
#include "tests/app/live/view_until.h"
#include "tests/app/run_pliant.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// The words of a demo that is made within a second.
std::vector<std::string> demo_words(const std::string& out, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"demo", "--out", out, "--gaussians", "2000", "--training", "0", "--photos", "6", "--width",
                             "80", "--height", "60", "--no-video"});
  return more;
}

size_t count_of(const fs::path& folder) {
  return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST(OutFolder, OfADemoMayEndWithASlash) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_quietly(demo_words((folder / "scene").string() + "/")), 0);
  EXPECT_TRUE(fs::exists(folder / "scene/scene.json"));
  EXPECT_TRUE(fs::exists(folder / "scene/demo.json"));
  EXPECT_EQ(count_of(folder.path()), 1u);
}

TEST(OutFolder, OfADemoKeepsWhatItHoldsWhereANewOneIsInterrupted) {
  const TemporaryFolder folder;
  const std::string out = (folder / "scene").string();
  ASSERT_EQ(run_quietly(demo_words(out)), 0);
  const auto before = folder_sums(folder.path());
  CLI::App app;
  Program program;
  add_demo(app, program);
  std::vector<std::string> words = demo_words(out, {"--overwrite", "--seed", "2"});
  std::reverse(words.begin(), words.end());
  app.parse(words);
  Progress progress(true);
  Context context{progress, [] { return true; }, 2, 1, true};
  expect_error(Failure::kInterrupted, {"demo"}, [&] { program.action(context); });
  EXPECT_EQ(folder_sums(folder.path()), before);
  EXPECT_FALSE(fs::exists(folder / "scene/.partial"));
}

TEST(OutFolder, OfADemoThatIsThereAlreadyStaysTheSameFolder) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "mount");
  const auto number = [&] {
    struct stat status = {};
    EXPECT_EQ(stat((folder / "mount").c_str(), &status), 0);
    return status.st_ino;
  };
  const auto first = number();
  ASSERT_EQ(run_quietly(demo_words((folder / "mount").string())), 0);
  const size_t entries = count_of(folder / "mount");
  const auto sums = folder_sums(folder / "mount");
  EXPECT_EQ(run_quietly(demo_words((folder / "mount").string(), {"--seed", "2"})), 2);
  EXPECT_EQ(folder_sums(folder / "mount"), sums);
  ASSERT_EQ(run_quietly(demo_words((folder / "mount").string(), {"--seed", "2", "--overwrite"})), 0);
  EXPECT_NE(folder_sums(folder / "mount"), sums);
  EXPECT_EQ(number(), first);
  EXPECT_EQ(count_of(folder / "mount"), entries) << "neither .partial nor .lock";
  EXPECT_EQ(count_of(folder.path()), 1u);
  // A scene file comes last: without it the scene is made again.
  const auto second = folder_sums(folder / "mount");
  fs::remove(folder / "mount/scene.json");
  ASSERT_EQ(run_quietly(demo_words((folder / "mount").string(), {"--seed", "2"})), 0);
  EXPECT_EQ(folder_sums(folder / "mount"), second);
}

TEST(OutFolder, OfADemoOfAnotherVersionIsReplacedOnlyWhereThatIsWanted) {
  const TemporaryFolder folder;
  const std::string out = (folder / "scene").string();
  ASSERT_EQ(run_quietly(demo_words(out)), 0);
  const auto sums = folder_sums(folder.path());
  json record = json::parse(read_text(folder / "scene/demo.json"));
  const std::string version = record["pliant"].dump();
  record["pliant"] = "0.0.1";
  const auto refused = [&](const std::string& text, const std::string& words) {
    write_text(folder / "scene/demo.json", text);
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly(demo_words(out)), 2);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find(words), std::string::npos) << said;
  };
  refused("[", "demo.json");
  refused(record.dump(), "'pliant' was \"0.0.1\", now " + version);
  const auto written = [&] { return fs::last_write_time(folder / "scene/splats.ply"); };
  for (const bool is_same : {false, true}) {
    const auto before = written();
    ASSERT_EQ(run_quietly(demo_words(out, {"--overwrite"})), 0);
    EXPECT_EQ(written() == before, is_same);
    EXPECT_EQ(folder_sums(folder.path()), sums);
  }
}

TEST(OutFolder, OfADemoWithFilesOfOthersIsRefused) {
  const TemporaryFolder folder;
  const std::string out = (folder / "scene").string();
  ASSERT_EQ(run_quietly(demo_words(out)), 0);
  folder.file("scene/run/run.json", "mine");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly(demo_words(out, {"--overwrite", "--seed", "2"})), 2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("'run'"), std::string::npos) << said;
  EXPECT_EQ(read_text(folder / "scene/run/run.json"), "mine");
  EXPECT_TRUE(fs::exists(folder / "scene/scene.json"));
}

TEST(OutFolder, OfATrainedSceneIsNotWhereItsSourceIs) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_quietly(demo_words((folder / "set").string())), 0);
  const std::string run = (folder / "run").string(), own = run + "/scene";
  const auto reconstruct = [&](const std::string& source, const std::string& iterations) {
    return std::vector<std::string>{"reconstruct",      source, "--out",  own,      "--iterations", iterations,
                                    "--max-image-size", "40",   "--init", "random", "--sh-degree",  "0",
                                    "--max-gaussians",  "500"};
  };
  for (const char* iterations : {"5", "6"})
    ASSERT_EQ(run_quietly(reconstruct((folder / "set").string(), iterations)), 0) << "photos elsewhere";
  const auto refused = [&](const std::vector<std::string>& words) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly(words), 2);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("contains the cameras"), std::string::npos) << said;
    EXPECT_EQ(count_of(fs::path(own) / "photos"), 6u);
    EXPECT_EQ(count_of(fs::path(own) / "masks"), 6u);
    EXPECT_TRUE(fs::exists(own + "/scene.json"));
  };
  refused(reconstruct(own, "7"));
  refused(reconstruct(own + "/transforms.json", "7"));
  // What lies below it under another name is not touched.
  fs::copy(folder / "set", fs::path(own) / "capture", fs::copy_options::recursive);
  EXPECT_EQ(run_quietly(reconstruct(own + "/capture", "5")), 0);
  EXPECT_TRUE(fs::exists(own + "/capture/transforms.json"));
  write_text(folder / "run/run.json", R"({"scene": null, "stages": {}})");
  refused({"segment", own, "--joint", "--out", run, "--reconstruct.iterations", "5"});
}

TEST(ViewedScene, IsLoadedAsBeforeAndDividedAnewWhereItsSplatsHaveChanged) {
  const TemporaryFolder folder;
  const MadeScene made =
      made_scene({{Vec3f(0, 0, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)}}, 4, 60, 45, 0.08f, 0.08f);
  write_ply(folder / "scene/splats.ply", made.cloud);
  write_cameras(folder / "scene/transforms.json", made.cameras);
  for (const Camera& camera : made.cameras)
    write_ids(folder / "scene/masks" / (camera.name + ".png"), cast_ids(made, camera));
  write_text(folder / "scene/scene.json",
             R"({"splats": "splats.ply", "cameras": "transforms.json", "masks": "masks"})");
  const std::string scene = (folder / "scene").string(), run = (folder / "run").string();
  ASSERT_EQ(
      run_quietly({"segment", scene, "--out", run, "--up", "0,0.1,1", "--metres-per-unit", "0.5", "--iterations", "2"}),
      0);
  const auto record = [&] { return json::parse(read_text(folder / "run/run.json")); };
  json before = record();
  before["assumed_height"] = 0.25;
  write_text(folder / "run/run.json", before.dump());
  const auto view = [&] { fixture::view_until({scene, "--out", run}, [] { return true; }); };
  view();
  EXPECT_EQ(record(), before);

  std::vector<int> order(made.cloud.size());
  std::iota(order.rbegin(), order.rend(), 0);
  for (const size_t kept : {order.size(), order.size() - 20}) {
    order.resize(kept);
    write_ply(folder / "scene/splats.ply", made.cloud.select(order));
    view();
    EXPECT_EQ(record()["stages"]["segment"]["inputs"]["splats"], sha256_of_file(folder / "scene/splats.ply"));
    EXPECT_EQ(read_segmentation(folder / "run/segmentation.h5").label.size(), kept);
    EXPECT_EQ(record()["scene"], before["scene"]);
  }
}

}  // namespace pliant
