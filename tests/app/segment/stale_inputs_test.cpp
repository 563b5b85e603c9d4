// A stage runs again by itself when something that it reads has changed: names of labels, the support, up.  Which
// changes concern which stages: stage_keys_test.cpp.

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
  json stage(const std::string& name) const { return json::parse(read_text(folder_ / "run/run.json"))["stages"][name]; }

  const std::string kTable = std::to_string(MadeScene::kTable);
  TemporaryFolder folder_;
  json settings_;
};

}  // namespace

TEST_F(StaleInputs, ChangedNamesOfLabelsAreSeen) {
  const json before = stage("segment");
  EXPECT_EQ(run_quietly(segment()), 0);  // nothing has changed
  EXPECT_EQ(stage("segment"), before);
  write_text(folder_ / "scene/labels.json", R"({"300": "apple"})");
  EXPECT_EQ(run_quietly(segment()), 0);
  EXPECT_NE(stage("segment")["inputs"]["labels"], before["inputs"]["labels"]);
  EXPECT_EQ(run_quietly(extract("ball")), 2);
  EXPECT_EQ(run_quietly(extract("apple")), 0);
  EXPECT_TRUE(fs::exists(folder_ / "run/objects/300_apple/object.ply"));
}

TEST_F(StaleInputs, AChangedSupportIsSeenByExtractAlone) {
  const json segmented = stage("segment"), extracted = stage("extract");
  settings_["support"] = kTable;
  write_settings();
  EXPECT_EQ(run_quietly(segment()), 0);
  EXPECT_EQ(stage("segment"), segmented);
  EXPECT_EQ(run_quietly(extract("ball")), 0);
  EXPECT_EQ(stage("extract")["scene"]["support"], kTable);
  EXPECT_NE(stage("extract"), extracted);
}

TEST_F(StaleInputs, ASupportThatIsNoObjectIsRefusedByExtract) {
  settings_["support"] = "tabel";
  write_settings();
  EXPECT_EQ(run_quietly(segment()), 0);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant(extract("ball")), 2);
  const std::string error = testing::internal::GetCapturedStderr();
  for (const char* word : {"scene.json: support: tabel", "300 = ball"})
    EXPECT_NE(error.find(word), std::string::npos) << word << " in: " << error;
  // Where names were changed by hand, one that is gone is no mistake of the file.
  ASSERT_EQ(run_quietly({"segment", "edit", (folder_ / "run").string(), "--name", "ball=apple"}), 0);
  EXPECT_EQ(run_quietly(extract("apple")), 0);
}

TEST_F(StaleInputs, ASupportOfWhichThereAreSeveralIsRefusedByExtract) {
  write_text(folder_ / "scene/labels.json", json({{"300", "thing"}, {kTable, "thing"}}).dump());
  settings_["support"] = "thing";
  write_settings();
  EXPECT_EQ(run_quietly(segment()), 0);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant(extract("300")), 2);
  const std::string error = testing::internal::GetCapturedStderr();
  for (const char* word : {"scene.json: support: thing", "several objects", "3, 300"})
    EXPECT_NE(error.find(word), std::string::npos) << word << " in: " << error;
}

TEST_F(StaleInputs, AChangedUpIsSeenByExtract) {
  settings_["up"] = {0, 0.1, 1};
  write_settings();
  EXPECT_EQ(run_quietly(extract("ball")), 0);
  EXPECT_GT(stage("extract")["scene"]["up"][1].get<double>(), 0.05);
}

TEST_F(StaleInputs, EditsByHandAreMovedAsideWhereObjectsAreFoundAgain) {
  ASSERT_EQ(run_quietly({"segment", "edit", (folder_ / "run").string(), "--name", "ball=apple"}), 0);
  const std::string edited = read_text(folder_ / "run/objects.json");
  EXPECT_EQ(run_quietly(segment()), 0);  // nothing else has changed
  EXPECT_EQ(read_text(folder_ / "run/objects.json"), edited);
  write_text(folder_ / "scene/labels.json", R"({"300": "globe"})");
  EXPECT_EQ(run_quietly(segment()), 0);
  EXPECT_EQ(read_text(folder_ / "run/objects.json.1"), edited);
  EXPECT_TRUE(fs::exists(folder_ / "run/segmentation.h5.1"));
  EXPECT_NE(read_text(folder_ / "run/objects.json").find("globe"), std::string::npos);
  EXPECT_FALSE(json::parse(read_text(folder_ / "run/run.json")).contains("edits"));
  // What nobody has edited is replaced.
  write_text(folder_ / "scene/labels.json", R"({"300": "sphere"})");
  EXPECT_EQ(run_quietly(segment()), 0);
  EXPECT_NE(read_text(folder_ / "run/objects.json").find("sphere"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "run/objects.json.2"));
}

}  // namespace pliant
