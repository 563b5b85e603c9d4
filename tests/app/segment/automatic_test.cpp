// From splats alone to objects, through the command line.

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "gaussians/io/files/files.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using nlohmann::json;

TEST(AutomaticSegmentation, FindsWhatStandsOnTheTableWithNoMasksAndNoPrompts) {
  const TemporaryFolder folder;
  const std::string scene = (folder / "scene").string(), out = (folder / "run").string(),
                    score = (folder / "score.json").string();
  ASSERT_EQ(run_quietly({"demo", "--out", scene, "--gaussians", "10000", "--photos", "12", "--width", "160", "--height",
                         "120", "--no-video"}),
            0);
  ASSERT_EQ(run_quietly({"segment", scene, "--out", out, "--auto", "--hold-out"}), 0);

  // Kinds and reasons are told, and every Gaussian belongs to something.
  std::map<std::string, int> kinds;
  size_t gaussians = 0;
  for (const json& object : json::parse(read_text(folder / "run/objects.json"))) {
    ++kinds[object.at("kind").get<std::string>()];
    gaussians += object.at("gaussians").get<size_t>();
    EXPECT_FALSE(object.at("found").get<std::string>().empty());
  }
  EXPECT_EQ(kinds["object"], 4);   // flower, ball, box and mug
  EXPECT_EQ(kinds["support"], 2);  // table and wall
  EXPECT_GT(gaussians, 9000u);

  // Views that were not looked at show them where they are; only `evaluate` reads the true masks.
  ASSERT_EQ(run_quietly({"evaluate", "segmentation", out + "/held_out", scene + "/masks", "--match", "overlap",
                         "--common", "--out", score, "--assert", "miou>=0.85"}),
            0);
  const json scores = json::parse(read_text(score));
  for (const auto& [id, row] : scores.at("per_id").items()) EXPECT_GT(row.at("iou"), 0.7) << row.dump();

  // A support is no object to cut, whatever either is called.
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "support_1=table", "--name", "support_2=wall", "--name",
                         "object_1=support_arm"}),
            0);
  ASSERT_EQ(run_quietly({"extract", out}), 0);
  const json cut = json::parse(read_text(folder / "run/run.json"))["stages"]["extract"]["summary"];
  EXPECT_NE(cut.value("chosen", "").find("most prominent of 4 objects"), std::string::npos) << cut.dump();
  ASSERT_EQ(run_quietly({"segment", "edit", out, "--name", "table=support_1", "--name", "wall=support_2", "--name",
                         "support_arm=object_1"}),
            0);

  // Of the labels, only supports carry an object.
  const auto change = [&](const std::string& name, const std::string& kind) {
    json objects = json::parse(read_text(folder / "run/objects.json"));
    for (json& object : objects)
      if (object.at("name") == name) object["kind"] = kind;
    write_text(folder / "run/objects.json", objects.dump());
  };
  const auto carrier = [&] {
    EXPECT_EQ(run_quietly({"extract", out, "--object", "object_1"}), 0);
    const json summary = json::parse(read_text(folder / "run/run.json"))["stages"]["extract"]["summary"];
    return summary.contains("contact") ? summary["contact"]["support"].get<std::string>() : "";
  };
  EXPECT_EQ(carrier(), "support_1");

  // IDs and names like object_2 in the scene file are of its masks.
  const std::string settings_before = read_text(folder / "scene/scene.json");
  json settings = json::parse(settings_before), second;
  for (const json& object : json::parse(read_text(folder / "run/objects.json")))
    if (object.at("name") == "object_2") second = object;
  ASSERT_TRUE(second.is_object());
  settings["object"] = "object_2";
  for (const std::string& support : {second.at("id").dump(), std::string("object_2")}) {
    settings["support"] = support;
    write_text(folder / "scene/scene.json", settings.dump());
    EXPECT_EQ(carrier(), "support_1") << support;
  }
  ASSERT_EQ(run_quietly({"extract", out}), 0);
  EXPECT_TRUE(json::parse(read_text(folder / "run/run.json"))["stages"]["extract"]["summary"].contains("chosen"));
  write_text(folder / "scene/scene.json", settings_before);

  change("support_1", "rest");
  EXPECT_EQ(carrier(), "");

  // What gets a name or is split off by hand is an object.
  const auto kind_of = [&](const std::string& name) {
    for (const json& object : json::parse(read_text(folder / "run/objects.json")))
      if (object.at("name") == name) return object.value("kind", "");
    return std::string("no such object");
  };
  EXPECT_EQ(run_quietly({"segment", "edit", out, "--name", "support_1=table", "--name", "support_2=wall", "--split",
                         "object_1"}),
            0);
  EXPECT_EQ(kind_of("table"), "object");
  EXPECT_EQ(kind_of("wall"), "support");
  EXPECT_EQ(kind_of("object_1_2"), "object");

  // Nothing else may be given with it.
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--auto", "--iterations", "20"}), 2);
  EXPECT_EQ(run_quietly({"segment", scene, "--out", out, "--auto", "--click", "view_000,80,60", "--overwrite"}), 2);
}

}  // namespace
}  // namespace pliant
