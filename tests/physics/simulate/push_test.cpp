// Pushes of a uniform stem, ten times as long as thick, clamped at its foot.

#include "physics/simulate/push.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "gaussians/base/error.h"
#include "physics/body/driving_particles.h"
#include "physics/body/make_particles.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kWidth = 0.02, kStem = 0.2, kStemFoot = 0.03;  // m

Particles stem(int count, double young = 3e5) {
  const double middle = 0.5 * kWidth;
  const SolidSamples samples = fixture::solid({kWidth, kWidth, kStem + kStemFoot}, kWidth / 14, [&](const Vec3d& x) {
    return std::hypot(x.x() - middle, x.y() - middle) < middle;
  });
  DriverOptions options;
  options.count = count;
  return make_particles<float>(kmeans_drivers(options, samples), samples,
                               ElasticSamples::homogeneous(samples.size(), young, 0.3, 1000), 1.0);
}

Interaction clamp() {
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, kStemFoot), Vec3d(0, 0, 1));
  return pin;
}

Interaction force(const Region& region, double newtons, double duration = std::numeric_limits<double>::infinity()) {
  Interaction push;
  push.type = InteractionType::kPointForce;
  push.region = region;
  push.duration = duration;
  push.vector = Vec3d(newtons, 0, 0);
  return push;
}

TEST(Push, TheSameNewtonsBendStemsOfAnyNumberOfParticlesAlike) {
  const auto peak = [](int count) {
    const Particles particles = stem(count);
    EXPECT_NEAR(particles.total_mass() / (1000 * 3.14159265 / 4 * kWidth * kWidth * (kStem + kStemFoot)), 1, 0.02);
    SimulateOptions options;
    options.duration = 0.15;
    const Interaction push = force(Region::box(Vec3d(-1, -1, kStemFoot + 0.8 * kStem), Vec3d(1, 1, 1)), 0.01);
    return simulate<float>(options, particles, {clamp(), push}, initial_state(particles)).summary.max_displacement;
  };
  const double fine = peak(4000), coarse = peak(1500);
  EXPECT_NEAR(coarse / fine, 1, 0.12) << fine << " " << coarse;
}

TEST(Push, IsSizedToTheStiffness) {
  PushOptions options;
  options.simulate.fps = 30;
  options.duration = 0.2;
  options.fraction = 0.15;
  options.max_particles = 800;
  const Region tip = Region::sphere(Vec3d(0.01, 0.01, kStemFoot + kStem), 0.02);
  double newtons[2];
  for (int k = 0; k < 2; ++k) {
    const Particles particles = stem(1200, k ? 3e5 : 1e5);
    const PushSize size = size_push(options, particles, {clamp()}, tip, Vec3d(2, 0, 0));
    newtons[k] = size.newtons;
    const Interaction push = force(tip, size.newtons, options.duration);
    SimulateOptions real = options.simulate;
    real.duration = 0.3;
    const double peak =
        simulate<float>(real, particles, {clamp(), push}, initial_state(particles)).summary.max_displacement;
    EXPECT_NEAR(peak / (kStem + kStemFoot), options.fraction, 0.35 * options.fraction);
    EXPECT_LE(size.trials, options.trials);
  }
  EXPECT_GT(newtons[1], 1.5 * newtons[0]);
}

TEST(Push, IsAsLargeAsWantedOnTheBodyItselfHoweverCoarseTheTrialBody) {
  PushOptions options;
  options.simulate.fps = 60;
  options.duration = 0.1;
  options.max_particles = 150;
  options.scale_on_body = true;
  const Region tip = Region::sphere(Vec3d(0.01, 0.01, kStemFoot + kStem), 0.02);
  const Particles particles = stem(1200);
  const PushSize size = size_push(options, particles, {clamp()}, tip, Vec3d(1, 0, 0));
  EXPECT_LE(size.trials, options.trials + 1);
  const Interaction push = force(tip, size.newtons, options.duration);
  SimulateOptions real = options.simulate;
  real.duration = 2 * options.duration;
  const double peak =
      simulate<float>(real, particles, {clamp(), push}, initial_state(particles)).summary.max_displacement;
  EXPECT_NEAR(peak / (kStem + kStemFoot), options.fraction, 0.1 * options.fraction);
}

TEST(Push, SaysWhatShareIsDoneAndCanBeInterrupted) {
  PushOptions options;
  options.simulate.fps = 60;
  options.duration = 0.1;
  options.max_particles = 150;
  const Particles particles = stem(400);
  const Region tip = Region::sphere(Vec3d(0.01, 0.01, kStemFoot + kStem), 0.02);
  for (const bool on_body : {false, true}) {
    options.scale_on_body = on_body;
    std::vector<double> told;
    options.go_on = [&](double share) {
      told.push_back(share);
      return true;
    };
    size_push(options, particles, {clamp()}, tip, Vec3d(1, 0, 0));
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_GE(told.front(), 0);
    EXPECT_LE(told.back(), 1);
    const size_t half = told.size() / 2;
    size_t calls = 0;
    options.go_on = [&](double) { return ++calls < half; };
    try {
      size_push(options, particles, {clamp()}, tip, Vec3d(1, 0, 0));
      ADD_FAILURE() << "not interrupted";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kInterrupted);
    }
    EXPECT_EQ(calls, half) << "no work after that";
  }
}

TEST(Push, ARegionNarrowerThanACoarseCellStillTouchesTheCoarseBody) {
  PushOptions options;
  options.simulate.fps = 30;
  options.max_particles = 100;
  const double middle = 0.5 * kWidth, top = kStemFoot + kStem;
  const Particles particles = stem(1200);
  for (const Region& thin :
       {Region::box(Vec3d(0, 0, top - 0.003), Vec3d(kWidth, kWidth, top)),
        Region::cylinder(Vec3d(middle, 0, top - 0.004), Vec3d(middle, kWidth, top - 0.004), 0.002)})
    EXPECT_GT(size_push(options, particles, {clamp()}, thin, Vec3d(1, 0, 0)).newtons, 0);
}

TEST(Push, IsSizedToTheLaw) {
  PushOptions options;
  options.simulate.fps = 60;
  options.duration = 0.1;
  options.max_particles = 400;
  options.simulate.gravity.setZero();  // a fluid runs down the stem by itself
  Particles particles = stem(800);
  particles.materials[0].law = Law::kFluid;
  const PushSize size = size_push(options, particles, {clamp()}, Region::all(), Vec3d(1, 0, 0));
  const Interaction push = force(Region::all(), size.newtons, options.duration);
  SimulateOptions real = options.simulate;
  real.duration = 2 * options.duration;
  const double peak =
      simulate<float>(real, particles, {clamp(), push}, initial_state(particles)).summary.max_displacement;
  EXPECT_NEAR(peak / (kStem + kStemFoot), options.fraction, 0.35 * options.fraction) << "of a fluid";
}

TEST(Push, OfAFreeBodyIsNotSizedAgainstItsSag) {
  // It slides, so that what it needs follows from its inertia; under its own weight it sags by 8 % of its height.
  constexpr double kHeight = 0.08;
  const Particles particles = fixture::block<float>({0.04, 0.04, kHeight}, 0.01, 0.0, 5e3);
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  PushOptions options;
  options.simulate.fps = 100;
  options.simulate.settle_time = 5;
  options.duration = 0.06;
  const double way = options.fraction * kHeight,
               inert = particles.total_mass() * way / (1.5 * options.duration * options.duration);
  for (const double gravity : {0.0, 9.81}) {
    options.simulate.gravity = Vec3d(0, 0, -gravity);
    const PushSize size = size_push(options, particles, {ground}, Region::all(), Vec3d(1, 0, 0));
    EXPECT_NEAR(size.newtons / inert, 1, 0.2) << gravity;
    EXPECT_NEAR(size.peak_fraction / options.fraction, 1, 0.1) << gravity;

    const Interaction push = force(Region::all(), size.newtons, options.duration);
    SimulateOptions real = options.simulate;
    real.duration = 2 * options.duration;
    SimulationState first;
    double peak = 0;
    simulate<float>(real, particles, {ground, push}, initial_state(particles), [&](const SimulationState& s) {
      if (s.frame == 0) first = s;
      for (size_t i = 0; i < s.size(); ++i) peak = std::max(peak, static_cast<double>((s.x[i] - first.x[i]).norm()));
      return true;
    });
    EXPECT_NEAR(peak / way, 1, 0.2) << gravity;
  }
}

TEST(Push, ThatAFreeBodyOnTheGroundStandsIsFoundBetweenStickingAndSlidingAway) {
  // Below the friction of the ground it hardly moves, and far above it flies off.
  constexpr double kFriction = 0.5, kGravity = 9.81;
  const Particles particles = fixture::block<float>({0.04, 0.04, 0.04}, 0.01, 0.0, 2e5);
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  ground.friction = kFriction;
  PushOptions options;
  options.simulate.fps = 100;
  options.simulate.settle_time = 2;
  options.simulate.gravity = Vec3d(0, 0, -kGravity);
  options.duration = 0.1;
  const PushSize size = size_push(options, particles, {ground}, Region::all(), Vec3d(1, 0, 0));
  EXPECT_NEAR(size.peak_fraction / options.fraction, 1, 0.3);
  // It slides while it is pushed, and is stopped by friction.
  const double weight = particles.total_mass() * kGravity;
  EXPECT_GT(size.newtons, 0.8 * kFriction * weight);
  EXPECT_LT(size.newtons, 3 * kFriction * weight);
  EXPECT_GT(size.trials, 1);
}

TEST(Push, ALooseFlapDoesNotSetTheLoad) {
  // A light grain beside the tip, which nothing holds, flies off at any force.
  Particles with_flap = stem(800);
  const Particles alone = with_flap;
  with_flap.position.push_back(Vec3f(0.01f + 0.03f, 0.01f, static_cast<float>(kStemFoot + kStem)));
  for (auto* column : {&with_flap.volume, &with_flap.mass, &with_flap.young, &with_flap.poisson}) {
    const float last = column->back();
    column->push_back(last);
  }
  const Region tip = Region::sphere(Vec3d(0.01, 0.01, kStemFoot + kStem), 0.05);
  PushOptions options;
  options.duration = 0.1;
  options.loose_share = 0.1;
  const double free_of_it = size_push(options, alone, {clamp()}, tip, Vec3d(1, 0, 0)).newtons;
  EXPECT_NEAR(size_push(options, with_flap, {clamp()}, tip, Vec3d(1, 0, 0)).newtons / free_of_it, 1, 0.1);
  options.loose_share.reset();
  EXPECT_LT(size_push(options, with_flap, {clamp()}, tip, Vec3d(1, 0, 0)).newtons, 0.8 * free_of_it);
}

TEST(Push, AMissedOrEmptyPushIsAUsageError) {
  const Particles particles = stem(300);
  const auto failure = [&](const Region& region, const Vec3d& direction) {
    try {
      size_push({}, particles, {clamp()}, region, direction);
    } catch (const Error& error) {
      return error.failure;
    }
    return Failure::kInterrupted;
  };
  EXPECT_EQ(failure(Region::sphere(Vec3d(9, 9, 9), 0.1), Vec3d(1, 0, 0)), Failure::kUsage);
  EXPECT_EQ(failure(Region::all(), Vec3d::Zero()), Failure::kUsage);
}

}  // namespace
}  // namespace pliant
