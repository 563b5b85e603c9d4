// Frames of an unfinished simulation.

#include "app/simulate/frame_store.h"

#include <gtest/gtest.h>

#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

// A body is settled, or its rest shape solved, before frame 0: who goes on from that frame would do it twice.
TEST(FrameStore, GoesOnFromTheLastFrameButTheFirst) {
  const TemporaryFolder folder;
  const SimulationState start = initial_state(fixture::block<float>({0.2, 0.1, 0.1}, 0.05, 0));
  SimulationState state = start;
  SimulateSummary summary;
  summary.settle_displacement = 0.25;
  FrameStore(folder / "a", "key").add(state, summary);
  state.x[0] += Vec3f(1, 0, 0);
  const auto resumed = [&](const char* key, SimulateSummary& of) {
    return FrameStore(folder / "a", key).resume(start, of).x;
  };
  SimulateSummary found;
  EXPECT_EQ(resumed("key", found), start.x);
  EXPECT_EQ(found.settle_displacement, 0);
  state.frame = 1;
  FrameStore(folder / "a", "key").add(state, summary);
  EXPECT_EQ(resumed("key", found), state.x);
  EXPECT_EQ(found.settle_displacement, 0.25);
  EXPECT_EQ(resumed("another", found), start.x) << "of another simulation";
}

}  // namespace
}  // namespace pliant
