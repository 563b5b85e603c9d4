// Frequency of the first sway: that of the lowest mode, proportional to the root of E, the same for any law.

#include "fitting/modal/sway.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fitting/modal/modes.h"
#include "gaussians/base/error.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

using namespace fixture;

TEST(SwayFrequency, IsThatOfTheLowestMode) {
  const TwinStem stem;
  const VibrationModes modes = vibration_modes({}, stem.particles, stem.pins);
  double lowest = INFINITY;
  for (const Vec3d& direction : {Vec3d(Vec3d::UnitX()), Vec3d(Vec3d::UnitY())}) {
    SwayOptions options;
    options.direction = direction;
    const std::optional<double> frequency = sway_frequency(options, stem.particles, stem.pins);
    ASSERT_TRUE(frequency);
    lowest = std::min(lowest, *frequency);
  }
  EXPECT_NEAR(lowest / (modes.omega[0] / (2 * M_PI)), 1, 0.08);
}

TEST(SwayFrequency, FollowsTheRootOfEAndOfOneOverTheDensity) {
  TwinStem stem;
  const double soft = *sway_frequency({}, stem.particles, stem.pins);
  for (float& E : stem.particles.young) E *= 9;
  const double stiff = *sway_frequency({}, stem.particles, stem.pins);
  EXPECT_NEAR(stiff / soft, 3, 0.01);
  for (float& mass : stem.particles.mass) mass *= 4;
  EXPECT_NEAR(*sway_frequency({}, stem.particles, stem.pins) / stiff, 0.5, 0.002);
}

TEST(SwayFrequency, IsNoneWhereTheBodyIsNotBackInTime) {
  const TwinStem stem;
  SwayOptions options;
  options.max_substeps = 16;
  EXPECT_FALSE(sway_frequency(options, stem.particles, stem.pins));
}

TEST(SwayFrequency, OfABodyThatNothingHoldsIsRefused) {
  const TwinStem stem;
  EXPECT_THROW(sway_frequency({}, stem.particles, {}), Error);
}

}  // namespace
}  // namespace pliant
