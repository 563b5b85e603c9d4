// Inverse statics and settling.

#include "physics/simulate/rest_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "gaussians/base/error.h"
#include "physics/simulate/settle.h"
#include "tests/physics/shapes.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;
constexpr double kGravity = 9.81, kLength = 0.08, kFoot = 0.03;

/// A beam of 3 x 3 x 8 cells that hangs out along x from a wall at x = 0.
BasicParticles<double> beam(double young) {
  auto p = fixture::block<double>({kLength + kFoot, 0.03, 0.03}, 0.01, 0.0, young);
  for (Vec3d& x : p.position) x.x() -= kFoot;
  return p;
}

Interaction wall() {
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitX());
  return pin;
}

double tip(const BasicParticles<double>& p, const State& s) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < s.size(); ++i)
    if (p.position[i].x() > kLength - 0.01) {
      sum += s.x[i].z() - p.position[i].z();
      ++count;
    }
  return sum / count;
}

TEST(RestShape, ASolvedBodyDoesNotDroopAndRisesByItsSagWhenGravityEnds) {
  const auto particles = beam(2.4e5);
  SimulateOptions options;
  options.fps = 50;
  options.duration = 1;
  options.rest_shape = RestShapeMode::kSolve;
  Interaction weightless;
  weightless.type = InteractionType::kGravity;
  weightless.start = 0.4;  // to the vector zero
  options.damping_time = 0.1;
  std::vector<State> states;
  const auto result = simulate<double>(options, particles, {wall(), weightless}, initial_state(particles),
                                       [&](const State& s) { return states.push_back(s), true; });
  const SimulateSummary& s = result.summary;
  std::printf("rest shape: %d iterations, residual %.4f mm, sag %.3f mm, %.2f s settled\n", s.rest_shape_iterations,
              1000 * s.rest_shape_residual, 1000 * s.rest_shape_sag, s.settle_seconds);
  EXPECT_FALSE(s.gravity_cancelled);
  EXPECT_LT(s.rest_shape_residual, 1e-3 * 0.12);
  double drift = 0;
  for (int f = 0; f <= 20; ++f)
    for (size_t i = 0; i < particles.size(); ++i)
      drift = std::max(drift, (states[f].x[i] - particles.position[i]).norm());
  EXPECT_LT(drift, 0.005 * kLength);

  // The sag of the same beam when it is loaded from its unloaded shape.
  SimulateOptions loading = options;
  loading.rest_shape = RestShapeMode::kCaptured;
  loading.gravity.setZero();
  Interaction load;
  load.type = InteractionType::kGravity;
  load.vector = Vec3d(0, 0, -kGravity);
  const double sag =
      -tip(particles, simulate<double>(loading, particles, {wall(), load}, initial_state(particles)).state);
  EXPECT_GT(sag, 0.002);
  EXPECT_NEAR(tip(particles, states.back()) / sag, 1, 0.05);
}

TEST(RestShape, AGivenMotionStartsFromTheSolvedShape) {
  const auto particles = beam(2.4e5);
  SimulateOptions options;
  options.fps = 100;
  options.grid = GridKind::kEulerian;
  State start = initial_state(particles);
  const Mat3d turn = Eigen::AngleAxisd(0.02, Vec3d::UnitY()).toRotationMatrix();
  for (size_t i = 0; i < start.size(); ++i) {
    const double out = std::max(0.0, particles.position[i].x()) / kLength;
    start.x[i].y() += 0.001 * out * out;
    start.v[i] = Vec3d(0, 0.5 * out * out, 0);
    start.F[i] = turn;
    start.C[i](1, 0) = out;
  }
  const auto run = [&](RestShapeMode mode, const State& from, double duration) {
    options.rest_shape = mode;
    options.duration = duration;
    std::vector<State> states;
    simulate<double>(options, particles, {wall()}, from, [&](const State& s) { return states.push_back(s), true; });
    return states;
  };
  const std::vector<State> still = run(RestShapeMode::kSolve, initial_state(particles), 0),
                           solved = run(RestShapeMode::kSolve, start, 0.15),
                           captured = run(RestShapeMode::kCaptured, start, 0.15);
  EXPECT_EQ(solved[0].v, start.v);
  EXPECT_EQ(solved[0].C, start.C);
  for (size_t i = 0; i < start.size(); ++i) {
    ASSERT_LT((solved[0].x[i] - still[0].x[i] - start.x[i] + particles.position[i]).norm(), 1e-12);
    ASSERT_LT((solved[0].F[i] - turn * still[0].F[i]).norm(), 1e-12);
  }
  const auto peak = [&](const std::vector<State>& states) {
    double most = 0;
    for (const State& s : states)
      for (size_t i = 0; i < s.size(); ++i) most = std::max(most, s.x[i].y() - particles.position[i].y());
    return most;
  };
  EXPECT_GT(peak(captured), 0.003);
  EXPECT_NEAR(peak(solved) / peak(captured), 1, 0.05);
}

TEST(RestShape, WithoutAPinIsAUsageError) {
  const auto particles = beam(6e4);
  EXPECT_THROW(solve_rest_shape<double>({}, particles, {}), Error);
}

TEST(RestShape, WhatBecomesUnstableOnTheWayIsSaidToBeTooSoft) {
  const auto particles = beam(2.4e5);
  RestShapeOptions options;
  options.simulate.substeps = 1;  // of 100
  options.simulate.max_retries = 0;
  try {
    solve_rest_shape<double>(options, particles, {wall()});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure, Failure::kNumerical);
    EXPECT_EQ(error.where, "rest shape");
    EXPECT_NE(error.remedy.find("raise Young's modulus"), std::string::npos) << error.remedy;
  }
}

TEST(Settle, AnObstacleThatWillMoveStandsWhereItIsAtTheStart) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 5e4);
  SimulateOptions options;
  options.fps = 50;
  options.duration = 0;
  options.settle_time = 1;
  Interaction plate, room, finger;
  plate.type = room.type = InteractionType::kCollider;
  plate.region = Region::box(Vec3d(-1, -1, -0.1), Vec3d(1, 1, 0));
  plate.friction = room.friction = finger.friction = INFINITY;
  room.region = Region::box(Vec3d(-0.1, -0.1, 0), Vec3d(0.2, 0.2, 0.5));
  room.container = true;
  finger.type = InteractionType::kPoke;
  finger.region = Region::sphere(Vec3d::Zero(), 0.3);
  finger.path = {{0, Vec3d(0.02, 0.02, -0.3)}, {1, Vec3d(0.02, 0.02, 1)}};
  Interaction sliding = plate, turning = plate, following = plate;
  sliding.vector = room.vector = Vec3d(0.5, 0, -2);
  turning.angular_velocity = Vec3d(0, 4, 0);
  // Its place at the start lies 5 cm lower than it is drawn.
  following.region = Region::box(Vec3d(-1, -1, -0.05), Vec3d(1, 1, 0.05));
  following.path = {{0, Vec3d(0, 0, -0.05)}, {1, Vec3d(0, 0, -1)}};
  for (const Interaction& it : {sliding, turning, following, room, finger}) {
    EXPECT_TRUE(moves(it));
    const std::vector<Interaction> standing = resting_interactions({it});
    ASSERT_EQ(standing.size(), 1u);
    EXPECT_EQ(standing[0].path.size(), it.path.empty() ? 0u : 1u);
    const SimulateSummary summary = simulate<double>(options, particles, {it}, initial_state(particles)).summary;
    EXPECT_LT(summary.settle_displacement, 0.01) << interaction_name(it.type) << (it.container ? ", a room" : "");
    Interaction later = it;
    later.start = 0.1;
    EXPECT_TRUE(resting_interactions({later}).empty());
  }
  EXPECT_FALSE(moves(plate));
}

TEST(Settle, IsInterruptedAtTheNextFrame) {
  const auto p = fixture::block<float>({0.04, 0.04, 0.04}, 0.01);
  Interaction floor;
  floor.type = InteractionType::kGround;
  floor.region = Region::half_space(Vec3d(0, 0, -0.02), Vec3d(0, 0, 1));
  SimulateOptions options;
  options.settle_time = 5;
  int asked = 0;
  options.interrupted = [&] { return ++asked == 3; };
  expect_error(Failure::kInterrupted, {"interrupted"}, [&] { simulate<float>(options, p, {floor}, initial_state(p)); });
  EXPECT_EQ(asked, 3);
  Interaction pin = floor;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.01), Vec3d(0, 0, 1));
  options.rest_shape = RestShapeMode::kSolve;
  asked = 0;
  expect_error(Failure::kInterrupted, {"interrupted"}, [&] { simulate<float>(options, p, {pin}, initial_state(p)); });
  EXPECT_EQ(asked, 3);
}

TEST(Settle, ADroppedBodyEndsAtRestSoonAndSaysHowFarItFell) {
  auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 5e4);
  for (Vec3d& x : particles.position) x.z() += 0.02;
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.friction = 0.5;
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  SimulateOptions options;
  options.fps = 50;
  options.duration = 0.3;
  options.settle_time = 5;
  std::vector<State> states;
  const auto result = simulate<double>(options, particles, {ground}, initial_state(particles),
                                       [&](const State& s) { return states.push_back(s), true; });
  EXPECT_NEAR(result.summary.settle_displacement, 0.02, 0.006);
  EXPECT_LT(result.summary.settle_seconds, 2);
  EXPECT_TRUE(result.summary.warnings.empty()) << result.summary.warnings[0];
  double moved = 0;
  for (size_t i = 0; i < particles.size(); ++i) moved = std::max(moved, (states.back().x[i] - states[0].x[i]).norm());
  EXPECT_LT(moved, 5e-4);
}

TEST(Settle, HappensUnderTheGravityThatActsFromTheStartOn) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01, 0.0, 5e3);
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.friction = 0.5;
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  Interaction gravity;
  gravity.type = InteractionType::kGravity;
  SimulateOptions options;
  options.fps = 50;
  options.duration = 0.3;
  options.settle_time = 5;
  const auto moved_after = [&](double downwards, double world) {
    gravity.vector = Vec3d(0, 0, -downwards);
    options.gravity = Vec3d(0, 0, -world);
    State first;
    double moved = 0;
    const SimulateSummary summary =
        simulate<double>(options, particles, {ground, gravity}, initial_state(particles), [&](const State& s) {
          if (s.frame == 0) first = s;
          for (size_t i = 0; i < s.size(); ++i) moved = std::max(moved, (s.x[i] - first.x[i]).norm());
          return true;
        }).summary;
    return std::pair(moved, summary.settle_displacement);
  };
  const auto [weightless, still] = moved_after(0, kGravity);
  EXPECT_EQ(still, 0);
  EXPECT_LT(weightless, 1e-12);
  const auto [earth, sag] = moved_after(kGravity, kGravity);
  EXPECT_GT(sag, 1e-3);
  for (const double world : {kGravity, 0.0}) {
    const auto [moon, moon_sag] = moved_after(1.62, world);
    EXPECT_GT(moon_sag, 0.05 * sag) << world;
    EXPECT_LT(moon_sag, 0.5 * sag) << world;
    EXPECT_LT(moon, 0.2 * moon_sag) << world;
  }
  EXPECT_LT(earth, 0.1 * sag);
}

}  // namespace
}  // namespace pliant
