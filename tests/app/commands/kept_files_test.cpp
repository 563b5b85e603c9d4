// Commands that are given what is there already leave it as it was, or do again what it no longer holds for.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/store/segmentation.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
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

TEST(OutFolder, OfADemoStaysWhereANewOneFails) {
  const TemporaryFolder folder;
  // The folder's name leaves room for .lock, but not for .partial.
  const std::string name(249, 'a');
  folder.file(name + "/demo.json", "{}");
  EXPECT_NE(run_quietly(demo_words((folder / name).string() + "/", {"--overwrite"})), 0);
  EXPECT_EQ(read_text(folder / (name + "/demo.json")), "{}");
  EXPECT_EQ(count_of(folder / name), 1u);
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
    EXPECT_EQ(record()["stages"]["segment"]["inputs"]["splats splats.ply"],
              sha256_of_file(folder / "scene/splats.ply"));
    EXPECT_EQ(read_segmentation(folder / "run/segmentation.h5").label.size(), kept);
    EXPECT_EQ(record()["scene"], before["scene"]);
  }
}

}  // namespace pliant
