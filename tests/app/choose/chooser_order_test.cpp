// What is asked of the choice while it prepares the scene, answers marks or writes a selection.

#include <atomic>
#include <thread>

#include "app/segment/objects_file.h"
#include "tests/app/choose/choice.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

TEST_F(Choice, AnObjectOfTheListIsTheOneListedThoughMarksWait) {
  const uint32_t wanted = plant();
  const std::vector<uint32_t> before = read_objects(*run_, scene_).label;
  client_->receive(json({{"select", {{"clicks", {middle_of(wanted).click}}}}}).dump());
  ASSERT_TRUE(await("selected").is_object());
  client_->receive(json({{"name", {{"object", wanted}, {"name", "fern"}}}}).dump());
  const json things = await("kept")["things"];
  EXPECT_EQ(read_objects(*run_, scene_).label, before) << "the selection has not taken the place of the objects";
  bool named = false;
  for (const json& thing : things) {
    if (thing["id"] != wanted) continue;
    named = true;
    EXPECT_EQ(thing["name"], "fern");
    EXPECT_EQ(thing["gaussians"], static_cast<size_t>(std::count(before.begin(), before.end(), wanted)));
  }
  EXPECT_TRUE(named);
}

TEST_F(Choice, WhileTheObjectsAreBeingReplacedNoneOfThemIsTaken) {
  const uint32_t wanted = plant();
  gate_.close_at("segment: selecting by");
  client_->receive(json({{"select", {{"clicks", {middle_of(wanted).click}}}}}).dump());
  gate_.await_stop();
  client_->receive(json({{"make", {{"object", wanted}}}}).dump());
  EXPECT_NE(await("error").get<std::string>().find("being replaced"), std::string::npos);
  gate_.open();
  EXPECT_EQ(await("kept")["things"].size(), 2u);
}

TEST_F(Choice, WhatIsSelectedIsTakenOrNothingThoughItCouldNotBeWritten) {
  stop();
  std::atomic<int> failures = 2;
  progress_.listen([&](const ProgressEvent& event) {
    if (event.text.starts_with("segment: selecting by") && failures-- > 0) throw std::runtime_error("the disk is full");
  });
  start();
  const std::vector<uint32_t> before = read_objects(*run_, scene_).label;
  client_->receive(json({{"select", {{"clicks", {middle_of(plant()).click}}}}}).dump());
  const json selected = await("selected");
  EXPECT_EQ(await("failed"), "the disk is full") << "behind";
  const char* const kName = R"({"name": {"object": 0, "name": "fern"}})";
  client_->receive(kName);
  EXPECT_EQ(await("failed"), "the disk is full");
  EXPECT_EQ(read_objects(*run_, scene_).label, before);
  client_->receive(kName);
  await("kept");
  const json named = await("kept")["things"];
  ASSERT_EQ(named.size(), 2u);
  EXPECT_EQ(named[0]["name"], "fern");
  EXPECT_EQ(named[0]["gaussians"], selected["gaussians"]);
}

TEST_F(Choice, WithoutASelectionObjectZeroIsNone) {
  const std::string click = middle_of(plant()).click, make = R"({"make": {"object": 0}})";
  client_->receive(make);
  EXPECT_NE(await("failed").get<std::string>().find("no selection"), std::string::npos);
  client_->receive(json({{"select", {{"clicks", {click}}}}}).dump());
  EXPECT_EQ(await("kept")["things"].size(), 2u);
  const auto other = site_.handler().connect(std::make_shared<Inbox>());
  other->receive(R"({"select": {}})");
  client_->receive(make);
  EXPECT_NE(await("failed").get<std::string>().find("no selection"), std::string::npos);
  EXPECT_FALSE(run_->has("simulate"));
}

TEST_F(Choice, ARequestIsToldAtOnceAndTakenBackWhileTheSceneIsBeingPrepared) {
  const uint32_t wanted = plant();
  const std::string click = middle_of(wanted).click;
  stop();
  fs::remove(*run_ / "prepared_scene.bin");
  gate_.close_at("segment: preparing");
  start();
  gate_.await_stop();
  client_->receive(json({{"make", {{"object", wanted}}}}).dump());
  EXPECT_EQ(json::parse(inbox_->next()), json({{"busy", "make"}}));
  client_->receive(R"({"cancel": true})");
  EXPECT_EQ(json::parse(inbox_->next()), json({{"busy", ""}}));
  EXPECT_EQ(json::parse(inbox_->next()), json({{"failed", "Cancelled."}}));
  // The scene is prepared all the same.
  client_->receive(json({{"select", {{"clicks", {click}}}}}).dump());
  gate_.open();
  EXPECT_TRUE(await("selected").is_object());
  EXPECT_FALSE(run_->has("simulate"));
}

TEST_F(Choice, WhatFailsBehindIsToldOnTheConsoleAndToThoseWhoComeLater) {
  stop();
  fs::remove(*run_ / "prepared_scene.bin");
  std::atomic<bool> warned = false;
  progress_.listen([&](const ProgressEvent& event) {
    if (event.text.starts_with("segment: preparing")) throw std::runtime_error("the disk is full");
    if (event.warning && event.text.find("the disk is full") != std::string::npos) warned = true;
  });
  start();
  for (int k = 0; k < 1000 && !warned; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(warned);
  const auto late = std::make_shared<Inbox>();
  const auto client = site_.handler().connect(late);
  EXPECT_EQ(json::parse(late->next()), json({{"failed", "the disk is full"}}));
  client->receive(R"({"select": {"clicks": ["0,1,2"]}})");
  EXPECT_NE(json::parse(late->next())["error"].get<std::string>().find("could not be prepared"), std::string::npos);
}

TEST_F(Choice, MarksAreAnsweredAlthoughThePreparedSceneCannotBeKept) {
  const std::string click = middle_of(plant()).click;
  stop();
  fs::remove(*run_ / "prepared_scene.bin");
  fs::create_directories(*run_ / "prepared_scene.bin/of_somebody");
  gate_.close_at("segment: preparing");
  start();
  gate_.await_stop();
  client_->receive(json({{"select", {{"clicks", {click}}}}}).dump());
  gate_.open();
  EXPECT_TRUE(await("selected").is_object());
  EXPECT_NE(said_.find("cannot be kept"), std::string::npos) << said_;
}

TEST_F(Choice, AHoleThatCannotBeRepairedIsToldToWhoMovesTheObjectNowOrLater) {
  stop();
  run_->forget("repair");
  std::atomic<bool> warned = false;
  progress_.listen([&](const ProgressEvent& event) {
    if (event.text.starts_with("repair: ")) throw std::runtime_error("the disk is full");
    if (event.warning && event.text.find("could not be repaired: the disk is full") != std::string::npos) warned = true;
  });
  start();
  client_->receive(json({{"make", {{"object", plant()}, {"label", "potted plant"}}}}).dump());
  EXPECT_EQ(await("reload"), true);
  EXPECT_EQ(await("busy"), "");
  EXPECT_TRUE(warned);
  const auto late = std::make_shared<Inbox>();
  const auto mover = site_.handler().connect(late);
  EXPECT_NE(json::parse(late->next())["said"].get<std::string>().find("the disk is full"), std::string::npos);
  mover->receive(R"({"id": 1, "frames": 1})");
  EXPECT_EQ(late->next().substr(0, 4), "PLNT");
}

}  // namespace
}  // namespace pliant
