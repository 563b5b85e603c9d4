// Frames of a simulation: there and back, and damaged ones.

#include "app/store/frames.h"

#include <gtest/gtest.h>

#include "gaussians/io/files/files.h"
#include "tests/app/store/random_values.h"
#include "tests/temporary_folder.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

TEST(Frames, ContinueBitForBitAndAreCountedUpToTheFirstBadOne) {
  const TemporaryFolder folder;
  EXPECT_EQ(last_frame(folder / "partial"), -1);
  for (int i = 0; i < 4; ++i) {
    SimulationState state;
    state.frame = i;
    state.time = i / 30.0;
    state.substeps = 40 * i;
    state.x = vectors(9);
    state.v = vectors(9);
    state.C = matrices(9);
    state.F = matrices(9);
    if (i % 2 == 1)
      for (const Vec3f& x : vectors(9)) state.quiet_time.push_back(x.x());
    if (i % 2 == 0)
      for (const Mat3f& F : matrices(9)) state.memory.push_back({F, F.transpose(), F(1, 2)});
    write_frame(folder / "partial", state);
    const SimulationState back = read_frame(folder / "partial", i);
    EXPECT_EQ(back.time, state.time);
    EXPECT_EQ(back.substeps, state.substeps);
    EXPECT_EQ(back.x, state.x);
    EXPECT_EQ(back.v, state.v);
    EXPECT_EQ(back.C, state.C);
    EXPECT_EQ(back.F, state.F);
    EXPECT_EQ(back.quiet_time, state.quiet_time);
    ASSERT_EQ(back.memory.size(), state.memory.size());
    for (size_t k = 0; k < back.memory.size(); ++k) {
      EXPECT_EQ(back.memory[k].F_total, state.memory[k].F_total);
      EXPECT_EQ(back.memory[k].F_viscous, state.memory[k].F_viscous);
      EXPECT_EQ(back.memory[k].history, state.memory[k].history);
    }
  }
  EXPECT_EQ(last_frame(folder / "partial"), 3);
  const std::string good = read_text(folder / "partial/0002.bin");
  const auto damaged = [&](const std::string& bytes, std::vector<std::string> words) {
    folder.file("partial/0002.bin", bytes);
    words.push_back("0002.bin");
    expect_error(Failure::kInput, words, [&] { read_frame(folder / "partial", 2); });
    EXPECT_EQ(last_frame(folder / "partial"), 1);
  };
  damaged("", {"truncated"});
  damaged(good.substr(0, good.size() - 172), {"particles"});
  std::string changed = good;
  changed[200] ^= 1;
  damaged(changed, {"checksum"});
  changed = good;
  changed[0] = 'X';
  damaged(changed, {"magic"});
  changed = good;
  changed[15] = '\x7f';
  damaged(changed, {"particles"});
  changed = good;
  changed[16] = 3;
  damaged(changed, {"internal variables"});
  damaged(read_text(folder / "partial/0003.bin"), {"frame"});
  fs::remove(folder / "partial/0001.bin");
  EXPECT_EQ(last_frame(folder / "partial"), 0);
  expect_error(Failure::kInput, {"0001.bin", "does not exist"}, [&] { read_frame(folder / "partial", 1); });
}

}  // namespace
}  // namespace pliant
