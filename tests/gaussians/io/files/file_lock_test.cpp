#include "gaussians/io/files/file_lock.h"

#include <gtest/gtest.h>

#include "tests/held_elsewhere.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

TEST(FileLock, WhatAnotherProcessHoldsIsRefusedWithItsNumberUntilItEnds) {
  const TemporaryFolder folder;
  {
    const HeldElsewhere other(folder / "lock");
    expect_error(Failure::kUsage, {"results", "process " + std::to_string(other.process()), "another folder"},
                 [&] { FileLock(folder / "lock", "results"); });
    FileLock(folder / "other", "results");
  }
  FileLock(folder / "lock", "results");
}

TEST(FileLock, WhereNoFileCanBeMadeNothingIsHeld) {
  const TemporaryFolder folder;
  FileLock(folder / "none/lock", "results");
}

}  // namespace
}  // namespace pliant
