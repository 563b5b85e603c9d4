// The search over stiffness, on a twin of known stiffness: how far it reaches, and from when on it takes motion as
// free.

#include "fitting/modal/modal_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using fixture::TwinStem;

ModalSearch search(const TwinStem& twin, const TrackLoss<float>& tracks, double wrong, double farthest = 5) {
  Particles guess = twin.particles;
  for (float& E : guess.young) E = static_cast<float>(E * wrong);
  ModesOptions modes;
  modes.most = 4;
  ModalSearchOptions options;
  options.farthest = farthest;
  return modal_search(options, vibration_modes(modes, guess, twin.pins), guess, tracks, twin.fps);
}

TEST(ModalSearch, ReachesBeyondItsRangeWhileTheBestIsAtItsEnd) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, 40);
  const ModalSearch near = search(twin, tracks, 1);
  EXPECT_EQ(near.end, 0);
  EXPECT_NEAR(near.log10_factor.front(), -2, 1e-9);
  EXPECT_NEAR(near.log10_factor.back(), 2, 1e-9);
  for (const double wrong : {1e-3, 1e4}) {
    const ModalSearch far = search(twin, tracks, wrong);
    EXPECT_EQ(far.end, 0);
    EXPECT_NEAR(far.minima[0].log10_factor + std::log10(wrong), near.minima[0].log10_factor, 0.04);
    EXPECT_EQ(far.first_frame, near.first_frame);
  }
}

TEST(ModalSearch, EveryMinimumKnowsThePeriodsOfItsStrongestMode) {
  const TwinStem twin;
  const ModalSearch found = search(twin, twin.pushed(true, 0.02, 40), 1);
  EXPECT_EQ(found.periods, found.minima[0].periods);
  const double seconds = (40 - found.first_frame) / twin.fps;
  for (const ModalMotion& minimum : found.minima) {
    double strongest = 0, omega = 0;
    for (size_t k = 0; k < minimum.omega.size(); ++k)
      if (const double size = std::hypot(minimum.cosine[k], minimum.sine[k]); size > strongest) {
        strongest = size;
        omega = minimum.omega[k];
      }
    EXPECT_NEAR(minimum.periods, seconds * omega / (2 * std::numbers::pi), 1e-9);
  }
}

TEST(ModalSearch, ABestAtTheEndOfAllThatIsAllowedIsMarked) {
  const TwinStem twin;
  const TrackLoss<float> tracks = twin.pushed(true, 0.02, 40);
  const ModalSearch soft = search(twin, tracks, 1e-3, 2);
  EXPECT_EQ(soft.end, 1);
  EXPECT_NEAR(soft.minima[0].log10_factor, 2, 1e-9);
  EXPECT_EQ(soft.end_of(soft.minima[0]), 1);
}

TEST(ModalSearch, AStartAtTheLatestThatIsConsideredIsMarkedAndSoIsAPushWithoutEnd) {
  const TwinStem twin;  // pushed from frame 1 to 6
  const ModalSearch whole = search(twin, twin.pushed(true, 0.02, 40), 1);
  EXPECT_FALSE(whole.late);
  EXPECT_FALSE(whole.away);
  const ModalSearch pushed = search(twin, twin.pushed(true, 0.02, 4), 1);
  EXPECT_TRUE(pushed.late);
  EXPECT_TRUE(pushed.away);
}

}  // namespace
}  // namespace pliant
