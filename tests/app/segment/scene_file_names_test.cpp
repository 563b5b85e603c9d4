// How far the names in a scene file hold after a joint training on other masks, and what they mean after edits.

#include "app/segment/scene_file_names.h"

#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;
using Reach = FileNames::Reach;

json record_with_inputs(const json& inputs) {
  json record = {{"outputs", json::array()}, {"inputs", inputs}};
  for (const char* field : {"options", "scene", "found", "summary"}) record[field] = json::object();
  return record;
}

TEST(SceneFileNames, IdsHoldInAJointTrainingOnTheFilesMasksOnly) {
  const TemporaryFolder folder;
  const auto write_run = [&](const std::string& place, const std::string& stage, const json& inputs) {
    folder.file(place, json({{"scene", nullptr}, {"stages", {{stage, record_with_inputs(inputs)}}}}).dump());
  };
  write_run("run/run.json", "segment", {{"joint", "c"}});
  Scene scene;
  scene.source = folder / "scene";
  scene.settings.file = folder / "scene/scene.json";
  const RunDirectory run = RunDirectory::open(folder / "run");
  const auto names_after = [&](const json& inputs) {
    write_run("scene/run.json", "reconstruct", inputs);
    const FileNames names = names_of_file(run, scene, json::object());
    return std::pair(names.reach, names.ids);
  };
  EXPECT_EQ(names_after({{"masks", "a"}}), std::pair(Reach::kTrained, true));
  EXPECT_EQ(names_after({{"masks", "a"}, {"joint masks", "a"}}), std::pair(Reach::kTrained, true));
  EXPECT_EQ(names_after({{"masks", "a"}, {"joint masks", "b"}}), std::pair(Reach::kOther, false));
  EXPECT_EQ(names_after({{"joint masks", "b"}}), std::pair(Reach::kAll, true));
}

TEST(SceneFileNames, FollowRenamingsAndMerges) {
  const FileNames own{Reach::kOwn, true}, other{Reach::kOther, false}, given{Reach::kGiven, false};
  const json edits = json::parse(R"([{"renamed": ["flower", "tulip"]},
                                     {"merged": [[7, "tulip"], [9, "leaf"]], "into": 3},
                                     {"merged": [[3, "pot"]], "into": 4},
                                     {"renamed": ["vase", "jug"]}])");
  for (const char* name : {"flower", "7", "leaf", "9", "pot", "3"})
    EXPECT_EQ(present_name(own, edits, name), "4") << name;
  EXPECT_EQ(present_name(own, edits, "vase"), "jug");
  EXPECT_EQ(present_name(own, edits, "table"), "table");
  EXPECT_EQ(present_name(other, edits, "flower"), "4");
  EXPECT_EQ(present_name(other, edits, "7"), "") << "an ID of other masks";
  EXPECT_EQ(present_name(other, edits, "object_7"), "");
  EXPECT_EQ(present_name(given, edits, "flower"), "") << "no person has called anything so";
  EXPECT_EQ(present_name(given, edits, "tulip"), "4");
}

}  // namespace
}  // namespace pliant
