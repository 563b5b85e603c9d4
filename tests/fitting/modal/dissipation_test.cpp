#include "fitting/modal/dissipation.h"

#include <gtest/gtest.h>

#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using namespace fixture;

/// The stem swings for a second from a kick.
Motion<float> swing(const TwinStem& stem, double damping_time, double flip_time = 0) {
  Motion<float> motion{stem.particles, stem.kicked(0.2), stem.pins, {}};
  SimulateOptions& options = motion.options.simulate;
  options.fps = 50;
  options.duration = 1;
  options.substeps = 20;
  options.gravity.setZero();
  options.damping_time = damping_time;
  options.flip_time = flip_time;
  options.grid = GridKind::kEulerian;
  return motion;
}

TEST(Dissipation, OfALagrangianGridIsThatOfTheDragAlone) {
  const TwinStem stem;
  Motion<float> free = swing(stem, 0), slowed = swing(stem, 0.5);
  for (Motion<float>* motion : {&free, &slowed}) motion->options.simulate.grid = GridKind::kLagrangian;
  // What is left is motion that the particles do not see, against more than one on an Eulerian grid.
  EXPECT_LT(std::abs(dissipation_of(free).transfers), 0.1);
  EXPECT_NEAR(dissipation_of(slowed).whole, 1 / 0.5, 0.1);
}

TEST(Dissipation, ADragIsWhatTheWholeLosesBesideTheTransfers) {
  const TwinStem stem;
  const Dissipation free = dissipation_of(swing(stem, 0)), slowed = dissipation_of(swing(stem, 0.5));
  EXPECT_GT(free.transfers, 0);
  EXPECT_EQ(free.whole, free.transfers);
  EXPECT_NEAR(slowed.whole - free.transfers, 1 / 0.5, 0.1);
  EXPECT_NEAR(slowed.transfers / free.transfers, 1, 0.25);
}

TEST(Dissipation, IsLessForFinerGridsAndForTransfersThatKeepWhatTheGridCannotHold) {
  const TwinStem coarse;
  TwinStem fine;
  fine.particles = block<float>(Vec3d(0.02, 0.02, 0.09), 0.005, 0.5, 3e4, 0.3, 1000);
  const double of_coarse = dissipation_of(swing(coarse, 0)).transfers;
  EXPECT_LT(dissipation_of(swing(fine, 0)).transfers, 0.6 * of_coarse);
  EXPECT_LT(dissipation_of(swing(coarse, 0, 0.02)).transfers, 0.6 * of_coarse);
}

TEST(Dissipation, DragBesideTheTransfersLetsAMotionDieAwayAlikeOnEveryGrid) {
  TwinStem coarse, fine;
  fine.particles = block<float>(Vec3d(0.02, 0.02, 0.09), 0.005, 0.5, 3e4, 0.3, 1000);
  double beside[2];
  for (const TwinStem* stem : {&coarse, &fine}) {
    Motion<float> motion = swing(*stem, 0);
    motion.options.simulate.duration = 0.4;
    motion.options.simulate.damping_time = beside[stem == &fine] = damping_time_beside_transfers(motion, 0.4);
    EXPECT_NEAR(dissipation_of(motion).whole * 0.4, 1, 0.02);
  }
  EXPECT_GT(beside[0], beside[1]);
  EXPECT_GT(beside[1], 0.4);
  Motion<float> brief = swing(coarse, 0);
  brief.options.simulate.duration = 0.2;
  EXPECT_EQ(damping_time_beside_transfers(brief, 1e3), 0);  // the grid alone takes more
}

TEST(Dissipation, IsNothingWhereNothingMoves) {
  const TwinStem stem;
  Motion<float> motion = swing(stem, 0.5);
  motion.start = initial_state(stem.particles);
  EXPECT_EQ(dissipation_of(motion).whole, 0);
}

}  // namespace
}  // namespace pliant
