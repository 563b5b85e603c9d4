// Frames of an unfinished simulation.

#include "app/simulate/frame_store.h"

#include <gtest/gtest.h>

#include <tuple>

#include "gaussians/io/files/files.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// What of a summary adds up over the frames.
auto sums(const SimulateSummary& s) {
  return std::tie(s.frames, s.substeps_of_frame, s.min_dt, s.max_dt, s.max_displacement, s.max_stretch,
                  s.max_stretch_frame, s.max_stretch_place, s.settle_displacement, s.settle_seconds,
                  s.rest_shape_residual, s.rest_shape_sag, s.rest_shape_iterations, s.strays, s.retries,
                  s.particle_substeps, s.impulse_of_frame, s.warnings);
}

/// One in which each of them has a value of its own.
SimulateSummary some_summary() {
  SimulateSummary s;
  s.frames = 2;
  s.substeps_of_frame = {31, 37};
  s.min_dt = 1e-4;
  s.max_dt = 1.0 / 3000;
  s.max_displacement = 0.125;
  s.max_stretch = 2.5;
  s.max_stretch_frame = 1;
  s.max_stretch_place = Vec3d(0.1, 0.2, 0.3);
  s.settle_displacement = 0.25;
  s.settle_seconds = 1.5;
  s.rest_shape_residual = 1e-7;
  s.rest_shape_sag = 0.01;
  s.rest_shape_iterations = 5;
  s.strays = int64_t{1} << 40;
  s.retries = 3;
  s.particle_substeps = int64_t{1} << 50;
  s.impulse_of_frame = {{Vec3d(1, 2, 3), Vec3d(4, 5, 6)}, {Vec3d(0.1, -0.2, 0), Vec3d(7, 8, 9)}};
  s.warnings = {"one", "another"};
  return s;
}

// A body is settled, or its rest shape solved, before frame 0: who goes on from that frame would do it twice.
TEST(FrameStore, GoesOnFromTheLastFrameButTheFirst) {
  const TemporaryFolder folder;
  const SimulationState start = initial_state(fixture::block<float>({0.2, 0.1, 0.1}, 0.05, 0));
  SimulationState state = start;
  const SimulateSummary summary = some_summary();
  FrameStore(folder / "a", "key").add(state, summary);
  state.x[0] += Vec3f(1, 0, 0);
  const auto resumed = [&](const char* key, SimulateSummary& of) {
    return FrameStore(folder / "a", key).resume(start, of).x;
  };
  SimulateSummary found;
  EXPECT_EQ(resumed("key", found), start.x);
  EXPECT_TRUE(sums(found) == sums(SimulateSummary()));
  state.frame = 1;
  FrameStore(folder / "a", "key").add(state, summary);
  EXPECT_EQ(resumed("key", found), state.x);
  EXPECT_TRUE(sums(found) == sums(summary));
  // Without its summary a frame is none to go on from.
  const std::filesystem::path file = folder / "a/0001.json";
  const std::string whole = read_text(file);
  for (const std::string& damaged : {whole.substr(0, whole.size() / 2), std::string("[]"), std::string()}) {
    write_text(file, damaged);
    EXPECT_EQ(resumed("key", found), start.x) << damaged;
    EXPECT_TRUE(sums(found) == sums(SimulateSummary())) << damaged;
  }
  std::filesystem::remove(file);
  EXPECT_EQ(resumed("key", found), start.x);
  write_text(file, whole);
  EXPECT_EQ(resumed("key", found), state.x);
  EXPECT_EQ(resumed("another", found), start.x) << "of another simulation";
}

}  // namespace
}  // namespace pliant
