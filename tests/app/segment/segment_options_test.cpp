// What single options of segment change in the result, on one small demo scene.

#include <gtest/gtest.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/segment/segment_stage.h"
#include "gaussians/io/images/image_files.h"
#include "tests/app/painted_demo.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class SegmentOptions : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = fs::temp_directory_path() / ("pliant_segment_options_" + std::to_string(getpid()));
    fs::remove_all(folder);
    ASSERT_EQ(run_quietly({"demo", "--out", scene(), "--gaussians", "9000", "--photos", "8", "--width", "160",
                           "--height", "120", "--no-video"}),
              0);
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }

  static std::string scene() { return (folder / "scene").string(); }
  static int segment(const fs::path& out, std::vector<std::string> options) {
    std::vector<std::string> command = {"segment", scene(), "--out", out.string()};
    command.insert(command.end(), options.begin(), options.end());
    return run_quietly(command);
  }
  static json summary(const fs::path& run, const std::string& stage) {
    return json::parse(read_text(run / "run.json")).at("stages").at(stage).at("summary");
  }

  static fs::path folder;
};
fs::path SegmentOptions::folder;

TEST_F(SegmentOptions, ZeroAsBackgroundMakesAnObjectOfUnlabelledPixels) {
  const TemporaryFolder out;
  for (const auto& entry : fs::directory_iterator(folder / "scene/masks")) {  // only the flower stays labelled
    IdImage ids = read_ids(entry.path());
    for (uint32_t& id : ids.data) id = id == 1 ? 1 : 0;
    fs::create_directories(out / "masks");
    write_ids(out / "masks" / entry.path().filename(), ids);
  }
  const std::vector<std::string> masks = {"--masks", (out / "masks").string(), "--iterations", "20"};
  std::vector<std::string> with = masks;
  with.insert(with.end(), {"--mask-zero", "background"});
  testing::internal::CaptureStderr();
  EXPECT_EQ(segment(out / "plain", masks), 0);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("--mask-zero background"), std::string::npos) << said;  // everything has become the flower
  ASSERT_EQ(segment(out / "zero", with), 0);
  EXPECT_EQ(objects_of(out / "plain").count("background"), 0u);
  EXPECT_EQ(objects_of(out / "zero").count("background"), 1u);
  size_t background = 0, flower = 0;
  for (const json& object : json::parse(read_text(out / "zero/objects.json")))
    (object["name"] == "background" ? background : flower) = object["gaussians"];
  EXPECT_GT(background, 2 * flower);
}

TEST_F(SegmentOptions, MuchWithoutALabelIsToldAndLittleIsNot) {
  const TemporaryFolder out;
  for (const auto& entry : fs::directory_iterator(folder / "scene/masks")) {  // table and wall lose their labels
    IdImage ids = read_ids(entry.path());
    for (uint32_t& id : ids.data) id = id < 5 ? id : 0;
    fs::create_directories(out / "masks");
    write_ids(out / "masks" / entry.path().filename(), ids);
  }
  const auto said = [&](const fs::path& masks) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(segment(out / "run", {"--masks", masks.string(), "--iterations", "0"}), 0);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(folder / "scene/masks").find("has no label"), std::string::npos);
  const std::string much = said(out / "masks");
  EXPECT_NE(much.find("has no label"), std::string::npos) << much;
  EXPECT_NE(much.find("--mask-zero background"), std::string::npos) << much;
}

TEST_F(SegmentOptions, OptionsOfMasksAreRefusedWhereTheSceneHasNone) {
  const TemporaryFolder out;
  fs::copy(folder / "scene", out / "scene", fs::copy_options::recursive);
  json settings = json::parse(read_text(out / "scene/scene.json"));
  settings.erase("masks");
  write_text(out / "scene/scene.json", settings.dump());
  for (const auto& [option, value] :
       std::map<std::string, std::string>{{"--mask-zero", "background"}, {"--associate", "always"}}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(run_quietly({"segment", (out / "scene").string(), "--out", (out / "run").string(), option, value}), 2);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find(option), std::string::npos) << said;
    EXPECT_NE(said.find("--masks FOLDER"), std::string::npos) << said;
  }
}

TEST_F(SegmentOptions, StopsWhenAskedToInTheMiddleAndKeepsWhatThereIs) {
  const TemporaryFolder out;
  ASSERT_EQ(segment(out / "run", {"--iterations", "0"}), 0);
  const std::string before = read_text(out / "run/segmentation.h5");
  RunDirectory run = RunDirectory::open(out / "run");
  const Scene scene = load_run_scene(run);
  for (const int most : {0, 1, 6, 40}) {  // in the association, the preparation and the iterations
    Progress progress(true);
    int asked = 0;
    const Context context{progress, [&] { return ++asked > most; }};
    SegmentStage stage;
    stage.associate = "always";
    expect_error(Failure::kInterrupted, {"segment", "run the same command again"},
                 [&] { run_segment(context, run, scene, stage); });
    EXPECT_EQ(asked, most + 1);
  }
  EXPECT_EQ(read_text(out / "run/segmentation.h5"), before);
}

TEST_F(SegmentOptions, RendersStandInForPhotosThatCannotBeRead) {
  const TemporaryFolder out;
  fs::copy(folder / "scene", out / "scene", fs::copy_options::recursive);
  const std::vector<fs::path> photos = images_in(out / "scene/photos");
  ASSERT_EQ(photos.size(), 8u);
  for (size_t k = 1; k < photos.size(); ++k) {  // the first one tells the size of all
    const std::string bytes = read_text(photos[k]);
    write_text(photos[k], bytes.substr(0, bytes.size() / 2));
  }
  testing::internal::CaptureStderr();
  EXPECT_EQ(
      run_quietly({"segment", (out / "scene").string(), "--out", (out / "run").string(), "--sphere", "0,0,0.2,0.3"}),
      0);
  const std::string said = testing::internal::GetCapturedStderr(), words = "show renders in place of such photos";
  const size_t at = said.find(words);
  ASSERT_NE(at, std::string::npos) << said;
  EXPECT_EQ(said.find(words, at + 1), std::string::npos) << said;
  for (const char* file : {"segmentation.h5", "objects.json", "objects.png", "features.png"})
    EXPECT_TRUE(fs::exists(out / "run" / file)) << file;
}

TEST_F(SegmentOptions, NamesBesideTheMasksStayWithTheirIds) {
  const TemporaryFolder out;
  fs::copy(folder / "scene/masks", out / "masks");
  const json names = {{"1", "plant 1"}, {"2", "toy"}, {"3", "toy 2"}, {"4", "toy 7"}, {"5", "table"}, {"6", "wall"}};
  write_text(out / "masks/labels.json", names.dump());
  ASSERT_EQ(segment(out / "run", {"--masks", (out / "masks").string(), "--iterations", "0"}), 0);
  const json objects = json::parse(read_text(out / "run/objects.json"));
  EXPECT_EQ(objects.size(), names.size());
  for (const json& object : objects) EXPECT_EQ(object["name"], names.at(std::to_string(object["id"].get<uint32_t>())));
}

TEST_F(SegmentOptions, WithoutTheVoteTheAttributeStartsWorse) {
  const TemporaryFolder out;
  ASSERT_EQ(segment(out / "vote", {"--iterations", "3"}), 0);
  ASSERT_EQ(segment(out / "random", {"--iterations", "3", "--no-vote"}), 0);
  EXPECT_LT(summary(out / "vote", "segment")["cross_entropy"].get<double>(),
            0.5 * summary(out / "random", "segment")["cross_entropy"].get<double>());
  // Noise that nothing is learnt from tells nothing.
  testing::internal::CaptureStderr();
  EXPECT_EQ(segment(out / "noise", {"--iterations", "0", "--no-vote"}), 2);
  const std::string said = testing::internal::GetCapturedStderr();
  for (const char* word : {"--no-vote", "--iterations"}) EXPECT_NE(said.find(word), std::string::npos) << said;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_pliant({"segment", "--help"}), 0);
  const std::string help = testing::internal::GetCapturedStdout();
  EXPECT_NE(help.find("--no-vote "), std::string::npos);
  EXPECT_EQ(help.find("{false}"), std::string::npos);
}

}  // namespace
}  // namespace pliant
