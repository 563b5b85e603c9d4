// Marks: their order, what becomes of the objects they replace, and what is known of them later.

#include "app/choose/marks.h"

#include <algorithm>
#include <thread>

#include "app/segment/objects_file.h"
#include "app/store/segmentation.h"
#include "tests/app/choose/choice.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

TEST(SegmentBy, MarksOfThePageNameCamerasByNumberWhateverTheyAreCalled) {
  const SegmentStage stage = segment_by({{"box", "3,1,2,30,40"},
                                         {"click", "0,1,2"},
                                         {"click", "nowhere,1,2"},
                                         {"stroke", "fg,12,1,2,3,4"},
                                         {"grow", "5"}});
  EXPECT_EQ(stage.boxes, std::vector<std::string>{"#3,1,2,30,40"});
  EXPECT_EQ(stage.clicks, (std::vector<std::string>{"#0,1,2", "nowhere,1,2"}));
  EXPECT_EQ(stage.strokes, std::vector<std::string>{"fg,#12,1,2,3,4"});
  EXPECT_EQ(stage.grow, 5);
}

TEST(SegmentBy, ALaterMarkCountsOverAnEarlierOne) {
  const SegmentStage stage = segment_by({{"box", "1,1,2,30,40"},
                                         {"grow", "2"},
                                         {"click", "0,1,2"},
                                         {"stroke", "bg,0,5,6,7,8"},
                                         {"box", "11,1,2,30,40"},
                                         {"click", "0,5,6"},
                                         {"box", "1,3,4,30,40"},
                                         {"grow", "-1"}});
  EXPECT_EQ(stage.boxes, (std::vector<std::string>{"#11,1,2,30,40", "#1,3,4,30,40"})) << "one in a camera";
  EXPECT_EQ(stage.clicks, std::vector<std::string>{"#0,1,2"});
  EXPECT_EQ(stage.strokes, (std::vector<std::string>{"bg,#0,5,6,7,8", "fg,#0,5,6"})) << "clicks come before strokes";
  EXPECT_EQ(stage.grow, 1);
}

TEST_F(Choice, ANameStaysWithTheSelectionUntilOtherMarksShareNoneWithIt) {
  const Place place = middle_of(plant());
  const auto select = [&](const std::string& click, int grow) {
    client_->receive(json({{"select", {{"clicks", {click}}, {"grow", grow}}}}).dump());
  };
  select(place.click, 0);
  client_->receive(R"({"name": {"object": 0, "name": "Vase"}})");
  await("kept");
  EXPECT_EQ(await("kept")["things"][0]["name"], "Vase");
  EXPECT_EQ(await("busy"), "");
  for (const char* refused : {"7", "a,b"}) {
    client_->receive(json({{"name", {{"object", 0}, {"name", refused}}}}).dump());
    EXPECT_NE(await("failed").get<std::string>().find("--name"), std::string::npos) << refused;
    EXPECT_EQ(data()["things"][0]["name"], "Vase") << refused;
  }
  select(place.click, 1);
  EXPECT_EQ(await("kept")["things"][0]["name"], "Vase");
  EXPECT_FALSE(fs::exists(*run_ / "objects.json.2")) << "the page's own selection is replaced";
  client_->receive(R"({"select": {}})");  // an object was picked
  select(place.click, 2);
  EXPECT_EQ(await("kept")["things"][0]["name"], "Vase");
  client_->receive(R"({"select": {}})");
  select(place.click + "1", 0);
  EXPECT_EQ(await("kept")["things"][0]["name"], "object");
}

TEST_F(Choice, TheFirstMarkMovesLearnedObjectsAsideAndFindFindsThemAgain) {
  const std::string found = read_text(*run_ / "objects.json");
  const std::vector<uint32_t> label = read_objects(*run_, scene_).label;
  client_->receive(json({{"select", {{"clicks", {middle_of(plant()).click}}}}}).dump());
  EXPECT_EQ(await("kept")["things"].size(), 2u);
  EXPECT_NE(said_.find("objects.json.1"), std::string::npos) << said_;
  EXPECT_EQ(read_text(*run_ / "objects.json.1"), found);
  EXPECT_EQ(read_segmentation(*run_ / "segmentation.h5.1").label, label);
  client_->receive(R"({"find": true})");
  EXPECT_EQ(await("reload"), true);
  EXPECT_EQ(json::parse(read_text(*run_ / "objects.json"))[0]["found"], "masks");
  EXPECT_EQ(data()["things"].size(), json::parse(found).size());
}

TEST_F(Choice, WhatIsSelectedJustBeforeTheEndIsWritten) {
  client_->receive(json({{"select", {{"clicks", {middle_of(plant()).click}}}}}).dump());
  const json selected = await("selected");
  // The answer is told to the choice when all masks have been sent.
  for (size_t masks = 0; masks < shown_cameras(scene_).size(); ++masks) await("mask");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  site_.end();
  const std::vector<uint32_t> label = read_objects(*run_, scene_).label;
  EXPECT_EQ(static_cast<size_t>(std::count(label.begin(), label.end(), SelectionShape::kObject)),
            selected["gaussians"].get<size_t>());
}

TEST_F(Choice, WhoComesBeforeMarksAreWrittenIsToldThemInTheirOrder) {
  const Place place = middle_of(plant());
  const Marks marks = {{"click", place.click},
                       {"stroke", "bg," + std::to_string(place.camera) + ",1,1,2,2"},
                       {"click", place.click + "1"}};
  client_->receive(json({{"select", {{"marks", marks_json(marks)}}}}).dump());
  const auto late = std::make_shared<Inbox>();
  const auto client = site_.handler().connect(late);
  EXPECT_EQ(json::parse(late->next()), json({{"marks", marks_json(marks)}}));
  await("kept");
  EXPECT_NE(page().find(marks_json(marks).dump()), std::string::npos);
}

TEST_F(Choice, TheMarksAndTheNameOfASelectionAreKnownWhenItIsOpenedAgain) {
  EXPECT_TRUE(made_selection(*run_, scene_).marks.empty()) << "masks made the objects";
  const Place place = middle_of(plant());
  client_->receive(json({{"select", {{"clicks", {place.click}}, {"grow", 2}}}}).dump());
  client_->receive(R"({"name": {"object": 0, "name": "Vase=1"}})");
  await("kept");
  EXPECT_EQ(await("kept")["things"][0]["name"], "Vase=1");
  EXPECT_EQ(await("busy"), "");
  stop();
  start();
  const Marks marks = {{"click", place.click}, {"grow", "1"}, {"grow", "1"}};
  const MadeSelection made = made_selection(*run_, scene_);
  EXPECT_EQ(made.marks, marks);
  EXPECT_EQ(made.name, "Vase=1");
  EXPECT_NE(page().find(marks_json(marks).dump()), std::string::npos);
  client_->receive(json({{"select", {{"clicks", {place.click}}, {"grow", 1}}}}).dump());
  EXPECT_EQ(await("kept")["things"][0]["name"], "Vase=1");
  EXPECT_FALSE(fs::exists(*run_ / "objects.json.2")) << "the name alone is no edit to be kept";
  run_->set_note("edits", json::array({json{{"option", "--drop"}, {"value", "1"}}}));
  EXPECT_TRUE(made_selection(*run_, scene_).marks.empty()) << "a person has changed it";
}

}  // namespace
}  // namespace pliant
