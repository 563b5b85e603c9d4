// What a stage made before stays until there is a new result, and comes back where none is made.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "tests/app/run/run_directory_case.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

class ReplacingAResult : public RunDirectoryTest {
 protected:
  /// Runs the stage, whose body writes `files` and then fails with `failure`, unless that is none; how it ended.
  std::optional<Failure> attempt(int a, const std::vector<std::string>& files, std::optional<Failure> failure,
                                 bool overwrite = false) {
    StageKey work = key({{"a", a}});
    work.outputs = {"fit/out.txt", a == 1 ? "old.png" : a == 2 ? "new.png" : "third.png"};
    work.kept = {"fit"};
    RunDirectory directory = RunDirectory::create(folder_ / "run");
    Progress progress(true);
    const bool interrupted = failure == Failure::kInterrupted;
    try {
      directory.stage({progress, [=] { return interrupted; }, 1, 1, overwrite}, work, [&](const std::string&) {
        ++calls_;
        fs::create_directories(folder_ / "run/fit");
        for (const std::string& file : files) write_text(folder_ / "run" / file, std::to_string(a));
        if (killed_) _exit(0);
        if (failure) throw Error(*failure, "work", "", "ends early", "");
        return nlohmann::json{{"a", a}};
      });
    } catch (const Error& error) {
      return error.failure;
    }
    return std::nullopt;
  }
  /// The same in a process that is killed once the files are there.
  void attempt_and_be_killed(int a, const std::vector<std::string>& files) {
    const pid_t process = fork();
    killed_ = process == 0;
    if (killed_) attempt(a, files, {});
    waitpid(process, nullptr, 0);
  }
  /// The same in a process that is killed at the first byte that it writes: of the record that the stage has begun.
  void attempt_and_be_killed_before_it_is_recorded(int a) {
    const pid_t process = fork();
    if (process == 0) {
      const rlimit none = {0, 0};
      setrlimit(RLIMIT_FSIZE, &none);
      attempt(a, {}, {});
      _exit(0);
    }
    waitpid(process, nullptr, 0);
  }
  void make_first() { attempt(1, {"fit/out.txt", "old.png"}, {}); }
  void expect_first() {
    EXPECT_EQ(read_text(folder_ / "run/fit/out.txt"), "1");
    EXPECT_TRUE(fs::exists(folder_ / "run/old.png"));
    EXPECT_FALSE(fs::exists(folder_ / "run/fit.1"));
    const int before = calls_;
    make_first();
    EXPECT_EQ(calls_, before) << "the first result still counts";
  }

  bool killed_ = false;
};

TEST_F(ReplacingAResult, AStageThatFailsLeavesThePreviousOne) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/checkpoint"}, Failure::kUsage), Failure::kUsage);
  EXPECT_FALSE(fs::exists(folder_ / "run/fit/checkpoint"));
  expect_first();
  EXPECT_EQ(attempt(2, {}, Failure::kInput, true), Failure::kInput);
  expect_first();
  EXPECT_EQ(attempt(2, {"fit/out.txt", "new.png"}, {}), std::nullopt);
  EXPECT_FALSE(fs::exists(folder_ / "run/old.png"));
  EXPECT_EQ(read_text(folder_ / "run/fit.1/out.txt"), "1");
}

TEST_F(ReplacingAResult, WhatAFailedAttemptHasMadeIsThereWhenItIsRepeated) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/checkpoint"}, Failure::kInput), Failure::kInput);
  EXPECT_EQ(read_text(folder_ / "run/fit.failed/checkpoint"), "2");
  expect_first();
  EXPECT_EQ(attempt(3, {}, Failure::kInput), Failure::kInput);  // another one, which makes nothing
  EXPECT_EQ(attempt(2, {"fit/more"}, Failure::kNumerical), Failure::kNumerical);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.failed/checkpoint"));
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.failed/more"));
  expect_first();
  EXPECT_EQ(attempt(2, {"fit/out.txt", "new.png"}, {}), std::nullopt);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit/checkpoint"));
  EXPECT_FALSE(fs::exists(folder_ / "run/fit.failed"));
  EXPECT_EQ(read_text(folder_ / "run/fit.1/out.txt"), "1");
}

TEST_F(ReplacingAResult, WhatAKilledProgramHasNotRemovedIsRemovedOnceThereIsAResult) {
  make_first();
  attempt_and_be_killed(2, {"new.png"});
  EXPECT_TRUE(fs::exists(folder_ / "run/old.png"));
  attempt_and_be_killed(3, {});
  EXPECT_EQ(attempt(3, {"fit/out.txt", "third.png"}, {}), std::nullopt);
  EXPECT_FALSE(fs::exists(folder_ / "run/old.png"));
  EXPECT_FALSE(fs::exists(folder_ / "run/new.png"));
  EXPECT_TRUE(fs::exists(folder_ / "run/third.png"));
}

TEST_F(ReplacingAResult, WhatWasOverwrittenDoesNotCount) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/out.txt"}, Failure::kInput, true), Failure::kInput);
  EXPECT_FALSE(RunDirectory::open(folder_ / "run").has("work"));
}

TEST_F(ReplacingAResult, AnInterruptedStageGoesOnFromWhatItHasMade) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/checkpoint"}, Failure::kInterrupted), Failure::kInterrupted);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit/checkpoint"));
  EXPECT_EQ(read_text(folder_ / "run/fit.1/out.txt"), "1");
  EXPECT_EQ(RunDirectory::open(folder_ / "run").last_record("work")["options"]["a"], 2) << "what was being made";
}

TEST_F(ReplacingAResult, ThePreviousResultComesBackWhereTheInterruptedOneFailsOrIsGivenUp) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/checkpoint"}, Failure::kInterrupted), Failure::kInterrupted);
  EXPECT_EQ(attempt(2, {}, Failure::kInterrupted), Failure::kInterrupted);
  EXPECT_EQ(attempt(2, {}, Failure::kNumerical), Failure::kNumerical);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.failed/checkpoint"));
  expect_first();
  EXPECT_EQ(attempt(2, {}, Failure::kInterrupted), Failure::kInterrupted);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit/checkpoint")) << "taken up again";
  make_first();
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.failed/checkpoint"));
  expect_first();
  attempt_and_be_killed(2, {"fit/more"});
  EXPECT_EQ(attempt(3, {"fit/out.txt", "third.png"}, {}), std::nullopt);
  EXPECT_FALSE(fs::exists(folder_ / "run/fit/more"));
  EXPECT_TRUE(fs::exists(folder_ / "run/fit.failed/more"));
  EXPECT_EQ(read_text(folder_ / "run/fit.1/out.txt"), "1");
  EXPECT_FALSE(fs::exists(folder_ / "run/fit.2"));
}

TEST_F(ReplacingAResult, AProgramThatIsKilledAsItMovesThePreviousResultLosesNothing) {
  make_first();
  attempt_and_be_killed_before_it_is_recorded(2);
  expect_first();
  // Recorded as replaced, but not moved yet; or moved back, which is not recorded yet.
  for (const int next : {1, 3, 2}) {
    EXPECT_EQ(attempt(2, {}, Failure::kInterrupted), Failure::kInterrupted);
    fs::remove_all(folder_ / "run/fit");
    fs::rename(folder_ / "run/fit.1", folder_ / "run/fit");
    if (next != 1) {
      EXPECT_EQ(attempt(next, {}, Failure::kNumerical), Failure::kNumerical);
    }
    expect_first();
  }
  EXPECT_EQ(attempt(2, {"fit/out.txt", "new.png"}, {}), std::nullopt);
  EXPECT_EQ(read_text(folder_ / "run/fit.1/out.txt"), "1");
}

TEST_F(ReplacingAResult, AnInterruptedStageWhosePreviousResultIsGoneGoesOn) {
  make_first();
  EXPECT_EQ(attempt(2, {"fit/checkpoint"}, Failure::kInterrupted), Failure::kInterrupted);
  fs::remove_all(folder_ / "run/fit.1");
  EXPECT_EQ(attempt(2, {}, Failure::kInput), Failure::kInput);
  EXPECT_TRUE(fs::exists(folder_ / "run/fit/checkpoint"));
  EXPECT_FALSE(RunDirectory::open(folder_ / "run").has("work"));
}

TEST_F(ReplacingAResult, AStageThatIsDoneWhenItIsInterruptedCounts) {
  RunDirectory directory = RunDirectory::create(folder_ / "run");
  Progress progress(true);
  expect_error(Failure::kInterrupted, {"interrupted after this stage had finished"}, [&] {
    directory.stage({progress, [] { return true; }, 1, 1, false}, key({{"a", 1}}), [&](const std::string&) {
      write_text(folder_ / "run/out.txt", "done");
      return nlohmann::json{{"a", 1}};
    });
  });
  EXPECT_TRUE(RunDirectory::open(folder_ / "run").has("work"));
}

}  // namespace
}  // namespace pliant
