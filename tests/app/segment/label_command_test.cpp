// Photos to named objects through the command, with a detector whose answers are known.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/app/painted_demo.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class LabelCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::temp_directory_path() / ("pliant_label_command_" + std::to_string(getpid()));
    fs::remove_all(folder);
    make_painted_demo(folder / "scene");
    write_text(folder / "net.onnx", centroid_yolox(6.2f, 4));
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static int segment(const fs::path& out, std::vector<std::string> options) {
    std::vector<std::string> command = {
        "segment", (folder / "scene").string(), "--out", out.string(), "--iterations", "20", "--hold-out"};
    command.insert(command.end(), options.begin(), options.end());
    return run_quietly(command);
  }
  static std::string detector() { return (folder / "net.onnx").string(); }

  /// `id` of the result is the scene's box in photos and in views that were not learnt from.
  static void expect_box(const fs::path& run, uint32_t id) {
    EXPECT_GT(iou_in(run / "held_out", id, folder / "scene/masks", kRedThing), 0.8);
  }

  static fs::path folder;
};
fs::path LabelCommand::folder;

TEST_F(LabelCommand, ADetectorAloneMakesNamedObjectsOfWhatItSees) {
  const TemporaryFolder out;
  ASSERT_EQ(segment(out / "run", {"--detector", detector()}), 0);
  const auto objects = objects_of(out / "run");
  ASSERT_EQ(objects.count("leaf"), 1u);
  EXPECT_EQ(objects.count("sky"), 1u);
  EXPECT_EQ(objects.count("rest"), 1u);
  EXPECT_EQ(objects.size(), 3u);
  expect_box(out / "run", objects.find("leaf")->second);
  // The scene file names an object and a support of its masks, which these are not.
  ASSERT_EQ(run_quietly({"extract", (out / "run").string()}), 0);
  const json cut = json::parse(read_text(out / "run/run.json"))["stages"]["extract"]["summary"];
  EXPECT_NE(cut.value("chosen", "").find("most prominent of 2 objects"), std::string::npos) << cut;
  EXPECT_GT(iou_in(out / "run/held_out", objects.find("sky")->second, folder / "scene/masks", kBlueThing), 0.5);
}

TEST_F(LabelCommand, TextNamesTheOnlyThingThatBecomesAnObject) {
  const TemporaryFolder out;
  ASSERT_EQ(segment(out / "run", {"--detector", detector(), "--text", "green leaf"}), 0);
  const auto objects = objects_of(out / "run");
  ASSERT_EQ(objects.count("leaf"), 1u);
  EXPECT_EQ(objects.size(), 2u);  // and the rest
  expect_box(out / "run", objects.find("leaf")->second);
  EXPECT_EQ(segment(out / "other", {"--detector", detector(), "--text", "elephant"}), 2);
}

TEST_F(LabelCommand, APhotoThatHasItsRecordIsNotLabelledAgain) {
  const TemporaryFolder out;
  const std::vector<std::string> options = {"--label-photos", "--detector", detector()};
  ASSERT_EQ(segment(out / "run", options), 0);
  const fs::path photos = out / "run/labelled/photos";
  const std::string first = read_text(photos / "view_002.json");
  json kept = json::parse(read_text(photos / "view_001.json"));
  ASSERT_FALSE(kept.at("things").empty());
  for (json& thing : kept["things"]) thing["name"] = "kept " + thing["name"].get<std::string>();
  write_text(photos / "view_001.json", kept.dump());
  fs::remove(photos / "view_002.json");
  fs::remove(out / "run/labelled/labels.json");
  // Whatever comes of the changed masks, they were made from the record that was kept.
  std::vector<std::string> again = options;
  segment(out / "run", again);
  EXPECT_EQ(read_text(photos / "view_002.json"), first);
  std::set<std::string> names;
  const json labels = json::parse(read_text(out / "run/labelled/labels.json"));
  for (const auto& [id, name] : labels.items()) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"kept leaf", "kept sky", "leaf", "sky", "rest"}));

  // Records of other options do not count.
  again.insert(again.end(), {"--text", "leaf", "--overwrite"});
  ASSERT_EQ(segment(out / "run", again), 0);
  EXPECT_EQ(json::parse(read_text(photos / "view_001.json")).at("things").at(0).at("name"), "leaf");
}

TEST_F(LabelCommand, TrackedPhotosShareTheIdOfAThing) {
  const TemporaryFolder out;
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant({"segment", (folder / "scene").string(), "--out", (out / "run").string(), "--iterations", "20",
                        "--hold-out", "--track", "--detector", detector(), "--text", "green leaf"}),
            0);
  const std::string told = testing::internal::GetCapturedStderr(), other = "'leaf' is searched for";
  ASSERT_NE(told.find(other), std::string::npos) << told;
  EXPECT_EQ(told.find(other), told.rfind(other)) << told;
  const auto objects = objects_of(out / "run");
  ASSERT_EQ(objects.count("leaf"), 1u);
  const uint32_t leaf = objects.find("leaf")->second;
  EXPECT_EQ(json::parse(read_text(out / "run/labelled/labels.json")).at(std::to_string(leaf)), "leaf");
  EXPECT_GT(iou_in(out / "run/labelled", leaf, folder / "scene/masks", kRedThing), 0.8);
  expect_box(out / "run", leaf);
}

TEST(LabelCommandReal, ARealDetectorNamesThePottedFlower) {
  const char* given = std::getenv("PLIANT_DATA");
  fs::path net;
  for (const fs::path& data : {fs::path(given ? given : ""), fs::path(PLIANT_SOURCE_DIR) / "../shared/data",
                               fs::path(PLIANT_SOURCE_DIR) / "../../shared/data"})
    if (net.empty() && fs::exists(data / "weights/yolox_nano.onnx")) net = data / "weights/yolox_nano.onnx";
  if (net.empty()) GTEST_SKIP() << "weights/yolox_nano.onnx is absent (set PLIANT_DATA to its folder)";
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "9000", "--photos", "12", "--width", "240", "--height",
                         "180", "--no-video"}),
            0);
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--detector", net.string(), "--text", "vase", "--iterations",
                         "20", "--hold-out"}),
            0);
  double best = 0;
  for (const auto& [name, id] : objects_of(folder / "run")) {
    if (name != "rest") {
      EXPECT_EQ(name.rfind("vase", 0), 0u) << name;
    }
    if (name != "rest") best = std::max(best, iou_in(folder / "run/held_out", id, folder / "scene/masks", 1));
  }
  EXPECT_GT(best, 0.3);  // it is the pot that looks like a vase
}

TEST_F(LabelCommand, WhatIsMissingIsToldByTheOptionThatWasTyped) {
  const TemporaryFolder out;
  const std::string file = detector();
  const auto refused = [&](std::vector<std::string> options, const std::vector<std::string>& words) {
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(segment(out / "run", std::move(options)), 2);
    const std::string said = ::testing::internal::GetCapturedStderr();
    for (const std::string& word : words)
      EXPECT_NE(said.find(word), std::string::npos) << "'" << word << "' in: " << said;
    EXPECT_EQ(said.find("--label-photos"), std::string::npos) << said;
  };
  refused({"--segmenter", file}, {"--segmenter", "net.onnx", "--click", "--detector"});
  refused({"--tagger", file}, {"--tagger", "net.onnx", "--detector"});
  refused({"--text", "leaf"}, {"--text", "leaf", "--detector"});
  refused({"--tracker", file}, {"--tracker", "net.onnx", "--track"});
  refused({"--tracker", file, "--detector", file}, {"--tracker", "net.onnx", "--track"});
  refused({"--detector", file, "--click", "0,20,20"}, {"--detector", "net.onnx", "selection"});
  refused({"--everything", "--tagger", file}, {"--everything", "--tagger"});
  refused({"--vocabulary", file}, {"--vocabulary", "net.onnx", "--detector"});
  refused({"--inpainter", file}, {"--inpainter"});
  refused({"--detector", file, "--text", " , ."}, {"--text", "holds no name"});
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(run_quietly({"repair", out.path().string(), "--detector", file}), 2);
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("--detector"), std::string::npos);
}

}  // namespace
}  // namespace pliant
