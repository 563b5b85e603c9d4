// A stage runs once for equal options and inputs, refuses other options unless asked to overwrite, and is done again
// when a file of the run directory itself changed.

#include "app/run/run_directory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/held_elsewhere.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

class RunDirectoryTest : public ::testing::Test {
 protected:
  RunDirectoryTest() : folder_(fs::temp_directory_path() / ("pliant_run_" + std::to_string(getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write_text(input_ = folder_ / "input.txt", "one");
  }
  ~RunDirectoryTest() override { fs::remove_all(folder_); }

  int run(const nlohmann::json& options, bool overwrite = false, const std::string& output = "out.txt") {
    RunDirectory directory = RunDirectory::create(folder_ / "run");
    Progress progress(true);
    const Context context{progress, [] { return false; }, 1, 1, overwrite};
    const StageKey key{"work", options, {{"input", input_}}, {output}};
    const auto summary = directory.stage(context, key, [&] {
      fs::create_directories((directory / output).parent_path());
      write_text(directory / output, "done");
      return nlohmann::json{{"calls", ++calls_}};
    });
    return summary["calls"];
  }

  fs::path folder_, input_;
  int calls_ = 0;
};

TEST_F(RunDirectoryTest, EqualOptionsAndInputsRunOnce) {
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_EQ(calls_, 1);
}

TEST_F(RunDirectoryTest, WhatAKilledProgramWasWritingIsCleanedAway) {
  fs::create_directories(folder_ / "run");
  write_text(folder_ / "run/.run.tmp123.json", "{");
  EXPECT_EQ(run({{"a", 1}}), 1);
  EXPECT_FALSE(fs::exists(folder_ / "run/.run.tmp123.json"));
  fs::create_directories(folder_ / "other");
  write_text(folder_ / "other/.notes.tmp.txt", "mine");
  EXPECT_THROW(RunDirectory::create(folder_ / "other"), Error);
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

TEST_F(RunDirectoryTest, AnotherOptionIsRefusedByNameUnlessOverwriting) {
  run({{"young", 1.0}});
  try {
    run({{"young", 2.0}});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure, Failure::kUsage);
    EXPECT_NE(std::string(error.what()).find("young"), std::string::npos);
  }
  EXPECT_EQ(run({{"young", 2.0}}, true), 2);
}

TEST_F(RunDirectoryTest, AnotherInputOfTheUserIsRefused) {
  run({});
  write_text(input_, "two");
  EXPECT_THROW(run({}), Error);
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

}  // namespace
}  // namespace pliant
