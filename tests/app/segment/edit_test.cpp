// `segment edit` on a run directory: files, later stages, repeating and undoing.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/run/attach_scene.h"
#include "app/segment/extract_stage.h"
#include "app/segment/objects_file.h"
#include "app/store/segmentation.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/images/image_io.h"
#include "tests/app/run_pliant.h"
#include "tests/held_elsewhere.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

const json* row(const json& objects, const std::string& name) {
  for (const json& object : objects)
    if (object["name"] == name) return &object;
  return nullptr;
}

TEST(SegmentEdit, ChangesTheObjectsOfARunKeepsThemAndCanBeUndone) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "6000", "--photos", "8", "--width", "120", "--height",
                         "90", "--no-video"}),
            0);
  const std::vector<std::string> segment = {"segment", scene, "--out", out, "--iterations", "20"};
  ASSERT_EQ(run_quietly(segment), 0);
  ASSERT_EQ(run_quietly({"extract", out, "--object", "flower"}), 0);
  const std::filesystem::path run = out;
  EXPECT_TRUE(std::filesystem::exists(run / "features.png"));
  const json before = read_json(run / "objects.json");
  const std::string found = sha256_of_file(run / "segmentation.h5"),
                    background = sha256_of_file(run / "background.ply");
  ASSERT_GE(before.size(), 3u);
  for (const json& object : before) {
    EXPECT_EQ(object["found"], "masks");
    EXPECT_GT(object["views"].get<int>(), 0) << object;
    for (const char* key : {"id", "score", "gaussians", "bounds"}) EXPECT_TRUE(object.contains(key)) << key;
  }
  ASSERT_TRUE(row(before, "flower") && row(before, "table"));

  // The wrong name changes nothing, not even what came before it on the command line.
  EXPECT_EQ(run_quietly({"segment", "edit", out, "--name", "flower=tulip", "--drop", "tabel"}), 2);
  EXPECT_EQ(sha256_of_file(run / "segmentation.h5"), found);
  // Nor is anything said to be done.
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant({"segment", "edit", out, "--drop", "table", "--split", "table"}), 2);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(said.find("was removed"), std::string::npos) << said;
  EXPECT_EQ(sha256_of_file(run / "segmentation.h5"), found);
  EXPECT_FALSE(read_json(run / "run.json").contains("edits"));
  {
    const HeldElsewhere other(run / ".lock");
    EXPECT_EQ(run_quietly({"segment", "edit", out, "--drop", "table"}), 2);
    EXPECT_EQ(sha256_of_file(run / "segmentation.h5"), found);
    EXPECT_EQ(read_json(run / "objects.json"), before);
  }
  EXPECT_EQ(run_quietly({"segment", "edit", out}), 2);
  EXPECT_EQ(run_quietly({"segment", "--out", out}), 2);

  // In the order of the command line: the new name is known to the merge.
  ASSERT_EQ(
      run_quietly({"segment", "edit", out, "--name", "flower=tulip", "--merge", "tulip,table", "--split", "tulip"}), 0);
  const json after = read_json(run / "objects.json");
  ASSERT_TRUE(row(after, "tulip"));
  EXPECT_EQ((*row(after, "tulip"))["id"], (*row(before, "flower"))["id"]);
  EXPECT_FALSE(row(after, "table"));
  EXPECT_EQ(read_json(run / "run.json")["edits"].size(), 3u);
  size_t total = 0, total_before = 0;
  for (const json& object : after) total += object["gaussians"].get<size_t>();
  for (const json& object : before) total_before += object["gaussians"].get<size_t>();
  EXPECT_EQ(total, total_before);
  const Segmentation segmentation = read_segmentation(run / "segmentation.h5");
  EXPECT_EQ(segmentation.class_id.size(), after.size());

  // Its folder has the new name, and run.json says so before extract has run again.
  const auto folder_of = [&](const std::string& name) {
    return run / ("objects/" + (*row(after, "tulip"))["id"].dump() + "_" + name);
  };
  EXPECT_FALSE(std::filesystem::exists(folder_of("flower")));
  EXPECT_TRUE(std::filesystem::exists(folder_of("tulip") / "object.ply"));
  const json extracted = read_json(run / "run.json")["stages"]["extract"];
  EXPECT_EQ(run / extracted["summary"]["folder"].get<std::string>(), folder_of("tulip"));
  EXPECT_EQ(run / extracted["outputs"][0].get<std::string>(), folder_of("tulip") / "object.ply");
  // What bears the name already is kept beside it.
  std::filesystem::create_directories(folder_of("rose"));
  write_text(folder_of("rose") / "object.ply", "somebody's");
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "tulip=rose"}), 0);
  EXPECT_EQ(read_text(folder_of("rose.1") / "object.ply"), "somebody's");
  EXPECT_GT(std::filesystem::file_size(folder_of("rose") / "object.ply"), 1000u);
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "rose=tulip"}), 0);
  EXPECT_TRUE(std::filesystem::exists(folder_of("tulip") / "object.ply"));

  // The scene file still calls it flower.
  ASSERT_EQ(run_quietly({"extract", out}), 0);
  EXPECT_EQ(read_json(run / "run.json")["stages"]["extract"]["summary"]["name"], "tulip");
  // Later stages run again by themselves; segment keeps the edits until it is told to overwrite.
  ASSERT_EQ(run_quietly({"extract", out, "--object", "tulip"}), 0);
  EXPECT_NE(sha256_of_file(run / "background.ply"), background);
  const std::string edited = sha256_of_file(run / "segmentation.h5");
  ASSERT_EQ(run_quietly(segment), 0);
  EXPECT_EQ(sha256_of_file(run / "segmentation.h5"), edited);
  std::vector<std::string> again = segment;
  again.push_back("--overwrite");
  ASSERT_EQ(run_quietly(again), 0);
  EXPECT_EQ(sha256_of_file(run / "segmentation.h5"), found);
  EXPECT_EQ(read_json(run / "objects.json"), before);
  EXPECT_FALSE(read_json(run / "run.json").contains("edits"));
}

TEST(SegmentEdit, ARenamedSupportStaysWhatTheObjectStandsOn) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "9000", "--photos", "8", "--width", "160", "--height",
                         "120", "--no-video"}),
            0);
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--iterations", "0"}), 0);
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "table=desk"}), 0);
  const RunDirectory run = RunDirectory::open(out);
  const json table = *row(read_json(run / "objects.json"), "desk");
  EXPECT_EQ(inputs_of(run, load_run_scene(run), ExtractStage()).found["support"], table["id"]);
  ASSERT_EQ(run_quietly({"extract", out}), 0);
  EXPECT_EQ(read_json(run / "run.json")["stages"]["extract"]["summary"]["contact"]["support"], "desk");
}

TEST(SegmentEdit, WhatTheSceneFileNamesIsInTheObjectThatItWasMergedInto) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "6000", "--photos", "8", "--width", "120", "--height",
                         "90", "--no-video"}),
            0);
  const std::filesystem::path file = folder / "scene/scene.json";
  for (const auto& [object, support] : {std::pair("flower", "table"), std::pair("1", "5")}) {
    json settings = read_json(file);
    settings.update({{"object", object}, {"support", support}});
    write_text(file, settings.dump());
    ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--iterations", "0", "--associate", "never", "--overwrite"}),
              0);
    const json before = read_json(folder / "run/objects.json");
    ASSERT_EQ((*row(before, "flower"))["id"], 1);
    ASSERT_EQ((*row(before, "table"))["id"], 5);
    std::vector<std::string> others;
    for (const json& other : before)
      if (other["id"] != 1 && other["id"] != 5 && other["name"] != "unlabelled") others.push_back(other["id"].dump());
    ASSERT_GE(others.size(), 2u);
    ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "flower=tulip", "--merge", others[0] + ",tulip", "--merge",
                           others[1] + ",table", "--name", others[1] + "=ground"}),
              0);
    const RunDirectory run = RunDirectory::open(out);
    const json found = inputs_of(run, load_run_scene(run), ExtractStage()).found;
    EXPECT_EQ(found["id"].dump(), others[0]) << object;
    EXPECT_EQ(found["support"].dump(), others[1]) << support;
    EXPECT_FALSE(found.contains("chosen")) << object;
  }
}

TEST(SegmentEdit, PicturesOfHeldOutPhotosShowTheEditedObjects) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "6000", "--photos", "8", "--width", "120", "--height",
                         "90", "--no-video"}),
            0);
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--iterations", "0", "--hold-out"}), 0);
  const auto pixels = [&](uint32_t id) {
    const IdImage ids = read_ids(folder / "run/held_out/view_000.png");
    return std::count(ids.data.begin(), ids.data.end(), id);
  };
  const auto flower = pixels(1), table = pixels(5);
  ASSERT_GT(flower, 0);
  ASSERT_GT(table, 0);
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--merge", "1,5"}), 0);
  EXPECT_EQ(pixels(5), 0);
  EXPECT_GE(pixels(1), table);
}

TEST(SegmentEdit, FoldersOfObjectsAreNamedWithinWhatFileSystemsTake) {
  const std::string folder = folder_of_object(7, std::string(300, 'a'));
  EXPECT_LE(std::filesystem::path(folder).filename().string().size(), 120u);
  EXPECT_NE(folder, folder_of_object(8, std::string(300, 'a')));
  EXPECT_EQ(folder_of_object(7, "big vase"), "objects/7_big_vase");
}

}  // namespace
}  // namespace pliant
