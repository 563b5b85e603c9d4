// A stage runs once for equal options and inputs and again when something of its key has changed; what cannot be made
// again cheaply is moved aside first.

#include "app/run/run_directory.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/app/run/run_directory_case.h"
#include "tests/held_elsewhere.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

TEST_F(RunDirectoryTest, EqualOptionsAndInputsRunOnce) {
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_EQ(calls_, 1);
}

TEST_F(RunDirectoryTest, WhatAKilledProgramWasWritingIsCleanedAway) {
  fs::create_directories(folder_ / "run");
  // No process has a number above 2^22.
  write_text(folder_ / "run/.run.tmp4194305.json", "{");
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_FALSE(fs::exists(folder_ / "run/.run.tmp4194305.json"));
  for (const char* name : {"run/objects/1_a/.solid.tmp4194305.h5", "run/fit/.results.tmp4194305.json"}) {
    write_text(folder_ / name, "{");
    EXPECT_EQ(run({{"a", 1}}), 1);
    EXPECT_FALSE(fs::exists(folder_ / name)) << name;
  }
  fs::create_directories(folder_ / "other");
  write_text(folder_ / "other/.notes.tmp.txt", "mine");
  EXPECT_THROW(RunDirectory::create(folder_ / "other"), Error);
  // It was training the scene that this is to be the run of.
  write_text(folder_ / "training/scene/run.json", "{}");
  EXPECT_NO_THROW(RunDirectory::create(folder_ / "training"));
  // It was about to, and had recorded nothing yet.
  for (const char* name : {".lock", "scene/.lock", "scene/.run.tmp5.json"}) write_text(folder_ / "begun" / name, "");
  EXPECT_NO_THROW(RunDirectory::create(folder_ / "begun"));
  write_text(folder_ / "begun/scene/notes.txt", "mine");
  EXPECT_THROW(RunDirectory::create(folder_ / "begun"), Error);
  write_text(folder_ / "file/scene", "mine");
  EXPECT_THROW(RunDirectory::create(folder_ / "file"), Error);
}

TEST_F(RunDirectoryTest, WhatAnotherProcessIsWritingStaysUntilItHasEnded) {
  fs::path file;
  {
    const HeldElsewhere other(folder_ / "elsewhere.lock");
    file = folder_ / ("run/recordings/.live_0001.tmp" + std::to_string(other.process()) + ".json");
    RunDirectory::create(folder_ / "run").set_scene("scene", false);
    write_text(file, "{");
    RunDirectory::open(folder_ / "run").hold();
    EXPECT_TRUE(fs::exists(file));
  }
  RunDirectory::open(folder_ / "run").hold();
  EXPECT_FALSE(fs::exists(file));
}

TEST_F(RunDirectoryTest, AFolderThatWasMadeAndThatNothingCameIntoGoesAgain) {
  {
    const RunDirectory made = RunDirectory::create(folder_ / "made"), copy = made;
    EXPECT_TRUE(fs::exists(folder_ / "made"));
  }
  EXPECT_FALSE(fs::exists(folder_ / "made"));
  RunDirectory::create(folder_ / "kept").set_scene("scene", false);
  EXPECT_TRUE(fs::exists(folder_ / "kept/run.json"));
  fs::create_directories(folder_ / "empty");
  RunDirectory::create(folder_ / "empty");
  EXPECT_TRUE(fs::exists(folder_ / "empty"));
}

TEST_F(RunDirectoryTest, AMissingOutputIsMadeAgain) {
  run({{"a", 1}});
  fs::remove(folder_ / "run" / "out.txt");
  EXPECT_EQ(run({{"a", 1}}), 2);
}

TEST_F(RunDirectoryTest, AFolderThatGetsAnotherNameIsFollowedAndFilesThatAreThereFromElsewhereAreNotTaken) {
  EXPECT_EQ(run({}, false, "a/out.txt"), 1);
  EXPECT_EQ(RunDirectory::open(folder_ / "run").move_folder("a", "b"), "");
  EXPECT_EQ(run({}, false, "b/out.txt"), 1);
  EXPECT_FALSE(fs::exists(folder_ / "run/a"));
  fs::create_directories(folder_ / "run/c");
  write_text(folder_ / "run/c/out.txt", "somebody's");
  EXPECT_EQ(run({}, false, "c/out.txt"), 2);
  write_text(folder_ / "run/b/out.txt", "mine");
  EXPECT_EQ(RunDirectory::open(folder_ / "run").move_folder("c", "b"), "b.1");
  EXPECT_EQ(read_text(folder_ / "run/b.1/out.txt"), "mine");
  EXPECT_EQ(run({}, false, "b/out.txt"), 2);
}

TEST_F(RunDirectoryTest, WhateverOfAKeyChangesRunsItAgainAndIsNamed) {
  StageKey work = key({{"young", 1.0}});
  work.scene = {{"up", {0, 0, 1}}};
  work.found = {{"height", 0.5}};
  EXPECT_EQ(run_key(work), 1);
  nlohmann::json record = record_of(work, 1);
  const auto expect_again = [&](const std::string& difference) {
    const int before = calls_;
    EXPECT_EQ(run_key(work), before + 1) << difference;
    EXPECT_EQ(run_key(work), before + 1) << difference;
    EXPECT_EQ(first_difference(record, record_of(work, 1)), difference);
    record = record_of(work, 1);
  };
  work.options["young"] = 2.0;
  expect_again("option 'young' was 1.0, now 2.0");
  work.options["poisson"] = 0.3;
  expect_again("option 'poisson' was absent, now 0.3");
  work.scene["up"] = {0, 1, 0};
  expect_again("scene setting 'up' was [0,0,1], now [0,1,0]");
  work.found.erase("height");
  expect_again("earlier result 'height' was 0.5, now absent");
  write_text(input_, "two");
  expect_again("input 'input' has changed");
  work.inputs["other"] = input_;
  expect_again("input 'other' was absent, now there");
}

TEST_F(RunDirectoryTest, WhatTookLongIsMovedAsideUnlessOverwriting) {
  StageKey work = key({{"a", 1}});
  work.outputs = {"fit/out.txt", "velocity.h5"};
  work.kept = {"fit", "velocity.h5", "never_there"};
  const auto run_with = [&](int a, bool overwrite) {
    work.options["a"] = a;
    run_key(work, overwrite);
    write_text(folder_ / "run/velocity.h5", std::to_string(a));
  };
  run_with(1, false);
  run_with(2, false);
  EXPECT_EQ(read_text(folder_ / "run/velocity.h5.1"), "1");
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.1/out.txt"));
  fs::remove(folder_ / "run/velocity.h5.1");
  run_with(3, false);  // one number for all that belongs together
  EXPECT_EQ(read_text(folder_ / "run/velocity.h5.2"), "2");
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.2/out.txt"));
  run_with(4, true);
  EXPECT_FALSE(fs::exists(folder_ / "run/velocity.h5.3"));
  EXPECT_EQ(read_text(folder_ / "run/velocity.h5"), "4");
}

// A new result replaces the previous one when it is there, not when it is begun.
TEST_F(RunDirectoryTest, ProvenanceHoldsTheRecordOfTheKey) {
  const StageKey work = key({{"a", 1}});
  run_key(work);
  const nlohmann::json provenance = nlohmann::json::parse(read_text(folder_ / "run/out.txt"));
  EXPECT_EQ(first_difference(provenance, record_of(work, 1)), "");
  EXPECT_EQ(provenance["stage"], "work");
  EXPECT_EQ(provenance["inputs"]["input"], hash_of_input(input_));
}

TEST_F(RunDirectoryTest, AChangedFileOfTheRunItselfIsFollowed) {
  input_ = folder_ / "run" / "inner.txt";
  fs::create_directories(folder_ / "run");
  RunDirectory::create(folder_ / "run").set_scene("scene", false);
  write_text(input_, "one");
  EXPECT_EQ(run({}), 1);
  write_text(input_, "two");
  EXPECT_EQ(run({}), 2);
}

TEST_F(RunDirectoryTest, AFolderWithOtherFilesIsNotTaken) {
  EXPECT_THROW(RunDirectory::create(folder_), Error);
  EXPECT_THROW(RunDirectory::open(folder_), Error);
}

TEST_F(RunDirectoryTest, WhileAnotherProcessWritesToItItMayOnlyBeRead) {
  EXPECT_EQ(run({{"a", 1}}), 1);
  const HeldElsewhere other(folder_ / "run/.lock");
  expect_error(Failure::kUsage, {"run", "another pliant", std::to_string(other.process())}, [&] { run({{"a", 1}}); });
  RunDirectory directory = RunDirectory::open(folder_ / "run");
  EXPECT_EQ(directory.summary("work", "")["calls"], 1);
  expect_error(Failure::kUsage, {"another pliant"}, [&] { directory.set_note("edits", {1}); });
}

TEST_F(RunDirectoryTest, WhatAnotherProgramWroteSinceItWasReadIsNotLost) {
  EXPECT_EQ(run({{"a", 1}}), 1);
  RunDirectory before = RunDirectory::open(folder_ / "run");
  RunDirectory::open(folder_ / "run").set_note("edits", {1});
  before.forget("work");
  EXPECT_EQ(RunDirectory::open(folder_ / "run").note("edits"), nlohmann::json({1}));
}

TEST_F(RunDirectoryTest, AnotherSceneIsRefused) {
  RunDirectory directory = RunDirectory::create(folder_ / "run");
  directory.set_scene({{"source", "a"}}, false);
  EXPECT_NO_THROW(directory.set_scene({{"source", "a"}}, false));
  EXPECT_THROW(directory.set_scene({{"source", "b"}}, false), Error);
}

TEST_F(RunDirectoryTest, WhereARecordSaysThatTheVideoLiesDoesNotCount) {
  StageKey work = key({});
  work.scene = {{"video", {{"camera", "c"}, {"fps", 24}, {"file", "/before/swing.mp4"}}}};
  EXPECT_EQ(run_key(work), 1);
  work.scene["video"].erase("file");
  EXPECT_EQ(run_key(work), 1);
  work.scene["video"]["fps"] = 25;
  EXPECT_EQ(run_key(work), 2);
}

TEST_F(RunDirectoryTest, ARecordThatIsIncompleteOrLeadsElsewhereIsRefused) {
  EXPECT_EQ(run({{"a", 1}}), 1);
  write_text(folder_ / "mine.txt", "mine");
  const nlohmann::json whole = nlohmann::json::parse(read_text(folder_ / "run/run.json"));
  const auto expect_refused = [&](const std::string& field, const std::function<void(nlohmann::json&)>& damage) {
    nlohmann::json record = whole;
    damage(record);
    write_text(folder_ / "run/run.json", record.dump());
    expect_error(Failure::kInput, {"run.json", field}, [&] { RunDirectory::open(folder_ / "run"); });
  };
  expect_refused("stages", [](nlohmann::json& r) { r.erase("scene"); });
  expect_refused("stages", [](nlohmann::json& r) { r["stages"] = 1; });
  for (const char* field : {"options", "scene", "found", "inputs", "outputs", "summary"})
    expect_refused(std::string("stages.work.") + field, [&](nlohmann::json& r) { r["stages"]["work"].erase(field); });
  for (const std::string& elsewhere : {std::string("../mine.txt"), (folder_ / "mine.txt").string(),
                                       std::string("a/../../mine.txt"), std::string("."), std::string()})
    for (const char* field : {"outputs", "kept"})
      expect_refused(field, [&](nlohmann::json& r) { r["stages"]["work"][field] = {elsewhere}; });
  expect_refused("begun.work.outputs", [](nlohmann::json& r) { r["begun"]["work"]["outputs"] = {"../mine.txt"}; });
  for (const char* field : {"record", "moved", "written"})
    expect_refused(std::string("begun.work.replaced.") + field, [&](nlohmann::json& r) {
      r["begun"]["work"]["replaced"] = {
          {"record", r["stages"]["work"]}, {"moved", nlohmann::json::array()}, {"written", nlohmann::json::array()}};
      const nlohmann::json pair = nlohmann::json::array({"../mine.txt", "../mine.txt"});
      r["begun"]["work"]["replaced"][field] = nlohmann::json::array({pair});
    });
  expect_refused("folder", [](nlohmann::json& r) { r["stages"]["work"]["summary"]["folder"] = "../other"; });
  EXPECT_EQ(read_text(folder_ / "mine.txt"), "mine");
}

}  // namespace
}  // namespace pliant
