// What whole simulations do at the ends: far away, unstable, impossible.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "gaussians/base/error.h"
#include "physics/body/make_particles.h"
#include "physics/laws/law.h"
#include "physics/mpm/mpm.h"
#include "physics/simulate/loads.h"
#include "physics/simulate/simulate.h"
#include "physics/simulate/simulator.h"
#include "tests/physics/shapes.h"
#include "tests/physics/simulate/recorded_motion.h"
#include "tests/physics/simulate/simulation_parts.h"

namespace pliant {
namespace {

using fixture::gust;
using fixture::options_of;
using fixture::pin_below;
using State = BasicSimulationState<double>;

TEST(Simulate, FarParticlesStayWhereTheyAreUpToTheBorderOfTheGrid) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01);
  SimulateOptions options = options_of(30, 0.1);
  options.grid = GridKind::kEulerian;
  options.gravity.setZero();
  for (const double far : {300.0, 3000.0}) {
    State start = initial_state(particles);
    start.x[7] = Vec3d(far, -20, 5);
    const auto result = simulate<double>(options, particles, {}, start);
    const bool within = far < 1000;  // 128,000 cells
    EXPECT_EQ(result.summary.strays == 0, within);
    EXPECT_NEAR(result.state.x[7].x(), within ? far : 1280, within ? 1e-9 : 1);
    EXPECT_LT((result.state.x[9] - particles.position[9]).norm(), 1e-9);
    const std::vector<std::string>& said = result.summary.warnings;
    EXPECT_EQ(std::none_of(said.begin(), said.end(), [](const auto& w) { return w.find("left") != w.npos; }), within);
  }
}

TEST(Simulate, WhatRestsIsNotMovedByTheRestOfTheBodyThatFliesAway) {
  auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01);
  particles.materials[0].law = Law::kSand;
  const size_t resting = fixture::append_copy(particles, Vec3d(0.1, 0, 0));
  fixture::append_copy(particles, Vec3d(0, 0.1, 0));  // three of four fly
  SimulateOptions options = options_of(30, 0.5);
  options.gravity.setZero();
  State start = initial_state(particles);
  for (size_t i = resting; i < start.size(); ++i) start.v[i] = Vec3d(0, 0, -5);
  const auto result = simulate<double>(options, particles, {}, start);
  EXPECT_EQ(result.summary.strays, 0);
  for (size_t i = 0; i < resting; ++i) EXPECT_LT((result.state.x[i] - particles.position[i]).norm(), 1e-9);
  EXPECT_NEAR(result.state.x.back().z(), particles.position.back().z() - 2.5, 1e-6);
}

TEST(Simulate, AnUnstableFrameIsRepeatedWithSmallerSteps) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01);
  SimulateOptions options = options_of(30, 0.2);
  // c = 3.67 m/s needs 31 substeps a frame; 4 are unstable until they have been halved often enough.
  options.substeps = 4;
  const auto result =
      simulate<double>(options, particles, {pin_below(0.02), gust(Vec3d(3, 0, 0))}, initial_state(particles));
  EXPECT_GT(result.summary.retries, 0);
  options.substeps = 0;
  const auto reference =
      simulate<double>(options, particles, {pin_below(0.02), gust(Vec3d(3, 0, 0))}, initial_state(particles));
  EXPECT_EQ(reference.summary.retries, 0);
  EXPECT_LT((result.state.x.back() - reference.state.x.back()).norm(), 0.01);
}

TEST(Simulate, AHopelessFrameIsANumericalFailureAfterTheLastGoodFrame) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01);
  Interaction blow;
  blow.type = InteractionType::kPointForce;
  blow.vector = Vec3d(1e30, 0, 0);
  blow.start = 0.1;
  blow.region = Region::sphere(Vec3d(0.02, 0.02, 0.05), 0.02);
  int frames = -1;
  try {
    simulate<double>(options_of(30, 1), particles, {blow}, initial_state(particles), [&](const State& s) {
      for (const Vec3d& x : s.x) EXPECT_TRUE(x.allFinite());
      frames = s.frame;
      return true;
    });
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure, Failure::kNumerical);
    EXPECT_NE(std::string(error.what()).find("frame 4"), std::string::npos) << error.what();
    EXPECT_NE(error.remedy.find("raise Young's modulus"), std::string::npos) << error.remedy;
  }
  EXPECT_EQ(frames, 3);
}

TEST(Simulate, AnUnstableFrameNamesTheSubstepsThatWereTriedOrTheirMaximum) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01);
  Interaction blow;
  blow.type = InteractionType::kPointForce;
  blow.vector = Vec3d(1e30, 0, 0);
  blow.region = Region::sphere(Vec3d(0.02, 0.02, 0.05), 0.02);
  SimulateOptions options = options_of(30, 0.1);
  options.substeps = 8;
  const auto said = [&] {
    try {
      simulate<double>(options, particles, {blow}, initial_state(particles));
    } catch (const Error& error) {
      EXPECT_EQ(error.failure, Failure::kNumerical);
      return error.problem;
    }
    return std::string("no error");
  };
  options.max_retries = 0;
  EXPECT_EQ(said(), "frame 1 stays unstable with 8 substeps");
  options.max_retries = 4;
  options.max_substeps = 10;
  EXPECT_EQ(said(), "frame 1 stays unstable with 8 substeps and needs more than the maximum of 10 substeps");
  options.max_substeps = 5;
  EXPECT_EQ(said(), "frame 1 needs more than the maximum of 5 substeps");
}

TEST(Simulate, WarnsWhereTheGridLocks) {
  SimulateOptions options;
  options.duration = 0;
  for (const double poisson : {0.45, 0.48, 0.49, 0.499}) {
    const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 0.0, 1e4, poisson, 1000);
    const auto warnings = simulate<double>(options, particles, {}, initial_state(particles)).summary.warnings;
    const bool warned = std::any_of(warnings.begin(), warnings.end(),
                                    [](const std::string& w) { return w.find("locking") != std::string::npos; });
    EXPECT_EQ(warned, poisson > kLockingPoisson) << poisson;
  }
}

TEST(Simulate, ImpossibleInputIsAUsageError) {
  const auto good = fixture::block<double>({0.03, 0.03, 0.03}, 0.01);
  const auto failure = [](auto&& call) {
    try {
      call();
    } catch (const Error& error) {
      return static_cast<int>(error.failure);
    }
    return 0;
  };
  const auto run = [&](const BasicParticles<double>& p, const SimulateOptions& o,
                       std::vector<Interaction> script = {}) {
    return failure([&] { simulate<double>(o, p, script, initial_state(p)); });
  };
  const SimulateOptions options = options_of(30, 0.1);
  EXPECT_EQ(run(good, options), 0);
  EXPECT_EQ(run({}, options), 2);
  auto bad = good;
  bad.young[3] = -1;
  EXPECT_EQ(run(bad, options), 2);
  bad = good;
  bad.poisson[3] = 0.5;
  EXPECT_EQ(run(bad, options), 2);
  bad = good;
  bad.mass[3] = 0;
  EXPECT_EQ(run(bad, options), 2);
  bad = good;
  bad.position[3].x() = NAN;
  EXPECT_EQ(run(bad, options), 2);
  for (const double fps : {0.0, -1.0, static_cast<double>(NAN)}) EXPECT_EQ(run(good, options_of(fps, 1)), 2);
  EXPECT_EQ(run(good, options_of(30, -1)), 2);
  Interaction miss = gust(Vec3d(1, 0, 0));
  miss.region = Region::sphere(Vec3d(5, 5, 5), 0.1);
  EXPECT_EQ(run(good, options, {miss}), 2);
  Interaction backwards = gust(Vec3d(1, 0, 0), -1);
  EXPECT_EQ(run(good, options, {backwards}), 2);
}

TEST(Simulate, SubstepsAtRestAreThoseOfABodyAtRest) {
  auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01);
  SimulateOptions options = options_of(50, 0.02);
  options.gravity.setZero();
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian})
    for (const double viscosity : {0.0, 1e-3})
      for (const double young : {1e4, 1e7}) {
        options.grid = grid;
        options.viscosity_time = viscosity;
        particles.young.assign(particles.size(), 1e4);
        particles.young[7] = young;
        const auto result = simulate<double>(options, particles, {}, initial_state(particles));
        EXPECT_EQ(substeps_at_rest(options, particles), result.summary.substeps_of_frame.at(0));
        if (young > 1e4) {
          EXPECT_EQ(fastest_wave(options, particles, particles.cell_size).particle, 7u);
        }
      }
}

}  // namespace
}  // namespace pliant
