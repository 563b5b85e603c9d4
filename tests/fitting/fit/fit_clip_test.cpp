// What gradients vary of a motion.

#include "fitting/fit/fit_clip.h"

#include <gtest/gtest.h>

#include "fitting/fields/part_field.h"
#include "fitting/objective/clip_objective.h"
#include "tests/fitting/twin_stem.h"

namespace pliant {
namespace {

TEST(FitClip, TheDampingOfAnUndampedMotionStaysZero) {
  constexpr int kFrames = 3;
  const fixture::TwinStem twin;
  Motion<float> motion;
  motion.particles = twin.particles;
  motion.interactions = twin.pins;
  motion.start = twin.kicked(0.5);
  motion.options.simulate.fps = twin.fps;
  motion.options.simulate.duration = kFrames / twin.fps;
  Objective<float> objective;
  objective.terms.push_back({1, std::make_shared<TrackLoss<float>>(twin.film(twin.pins, motion.start, true, kFrames))});
  ClipFitOptions options;
  options.material = std::make_shared<PartField>(motion.particles.size(), 1);
  options.gradient.iterations = 2;
  const ClipFit found = fit_clip(options, motion, objective, {});
  EXPECT_EQ(found.iterations.size(), 2u);
  EXPECT_EQ(found.motion.options.simulate.damping_time, 0);
}

}  // namespace
}  // namespace pliant
