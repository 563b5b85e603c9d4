// A stage does not call a result unchanged when something that it reads has changed: names of labels, the support, up.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/run_pliant.h"
#include "tests/segmentation/made_scene.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

class StaleInputs : public testing::Test {
 protected:
  void SetUp() override {
    const MadeScene scene = made_scene({{Vec3f(0, 0, 0.15f), 0.3f, 300, Vec3f(0.8f, 0.1f, 0.1f)}});
    fs::create_directories(folder_ / "scene/masks");
    write_ply(folder_ / "scene/splats.ply", scene.cloud);
    write_cameras(folder_ / "scene/transforms.json", scene.cameras);
    for (const Camera& camera : scene.cameras)
      write_ids(folder_ / "scene/masks" / (camera.name + ".png"), cast_ids(scene, camera));
    write_text(folder_ / "scene/labels.json", R"({"300": "ball"})");
    settings_ = {{"splats", "splats.ply"},
                 {"cameras", "transforms.json"},
                 {"masks", "masks"},
                 {"labels", "labels.json"},
                 {"up", {0, 0, 1}}};
    write_settings();
    ASSERT_EQ(run_quietly(segment()), 0);
    ASSERT_EQ(run_quietly(extract("ball")), 0);
  }
  void write_settings() { write_text(folder_ / "scene/scene.json", settings_.dump()); }
  std::vector<std::string> segment() const {
    return {"segment", (folder_ / "scene").string(), "--out", (folder_ / "run").string(), "--iterations", "5"};
  }
  std::vector<std::string> extract(const std::string& name) const {
    return {"extract", (folder_ / "run").string(), "--object", name};
  }
  static std::vector<std::string> overwriting(std::vector<std::string> command) {
    command.push_back("--overwrite");
    return command;
  }

  TemporaryFolder folder_;
  json settings_;
};

}  // namespace

TEST_F(StaleInputs, ChangedNamesOfLabelsAreSeen) {
  EXPECT_EQ(run_quietly(segment()), 0);  // nothing has changed
  write_text(folder_ / "scene/labels.json", R"({"300": "apple"})");
  EXPECT_EQ(run_quietly(segment()), 2);
  ASSERT_EQ(run_quietly(overwriting(segment())), 0);
  EXPECT_EQ(run_quietly(overwriting(extract("apple"))), 0);
}

TEST_F(StaleInputs, AChangedSupportIsSeenByExtract) {
  EXPECT_EQ(run_quietly(extract("ball")), 0);
  settings_["support"] = "ground";
  write_settings();
  EXPECT_EQ(run_quietly(segment()), 0);
  EXPECT_EQ(run_quietly(extract("ball")), 2);
}

TEST_F(StaleInputs, AChangedUpIsSeenByExtract) {
  settings_["up"] = {0, 0.1, 1};
  write_settings();
  EXPECT_EQ(run_quietly(extract("ball")), 2);
}

}  // namespace pliant
