// Each interaction's law.

#include "physics/simulate/interaction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gaussians/base/random.h"
#include "physics/body/driving_particles.h"
#include "physics/simulate/loads.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;

struct Experiment {
  BasicParticles<double> particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01);
  SimulateOptions options;
  std::vector<State> states;

  Experiment() {
    options.gravity.setZero();
    options.fps = 40;
    options.duration = 0.5;
  }
  BasicSimulateResult<double> go(const std::vector<Interaction>& script) {
    states.clear();
    return simulate<double>(options, particles, script, initial_state(particles),
                            [&](const State& s) { return states.push_back(s), true; });
  }
  Vec3d momentum(const State& s) const {
    Vec3d sum = Vec3d::Zero();
    for (size_t i = 0; i < s.size(); ++i) sum += particles.mass[i] * s.v[i];
    return sum;
  }
  /// About the centre of mass, the affine part of APIC included; a cell is 1 cm.
  Vec3d angular(const State& s) const {
    const Vec3d centre = this->centre(s);
    Vec3d sum = Vec3d::Zero();
    for (size_t i = 0; i < s.size(); ++i) {
      const Mat3d& C = s.C[i];
      const double inertia = 0.25 * particles.mass[i] * 1e-4;
      sum += particles.mass[i] * (s.x[i] - centre).cross(s.v[i]) +
             inertia * Vec3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
    }
    return sum;
  }
  Vec3d centre(const State& s, const Region& region = {}) const {
    Vec3d sum = Vec3d::Zero();
    double mass = 0;
    for (size_t i = 0; i < s.size(); ++i) {
      if (!region.contains(particles.position[i])) continue;
      sum += particles.mass[i] * s.x[i];
      mass += particles.mass[i];
    }
    return sum / mass;
  }
};

Interaction make(InteractionType type, const Vec3d& vector, double start = 0, double duration = INFINITY) {
  Interaction it;
  it.type = type;
  it.vector = vector;
  it.start = start;
  it.duration = duration;
  return it;
}

Interaction ground(double z, double friction) {
  Interaction it = make(InteractionType::kGround, Vec3d::Zero());
  it.region = Region::half_space(Vec3d(0, 0, z), Vec3d(0, 0, 1));
  it.friction = friction;
  return it;
}

TEST(Interaction, PointForceGivesItsNewtonsTimesItsSeconds) {
  Experiment run;
  // Neither end falls on a border of a frame or substep.
  Interaction push = make(InteractionType::kPointForce, Vec3d(0.02, -0.01, 0.005), 0.1037, 0.2311);
  push.region = Region::sphere(Vec3d(0.02, 0.02, 0.06), 0.02);
  run.go({push});
  const Vec3d gained = run.momentum(run.states.back());
  EXPECT_LT((gained - push.vector * push.duration).norm(), 1e-11 * gained.norm());
  EXPECT_EQ(run.momentum(run.states[4]).norm(), 0);  // 0.1 s
}

TEST(Interaction, ImpulseGivesItsMomentumAtOnce) {
  Experiment run;
  Interaction hit = make(InteractionType::kImpulse, Vec3d(0.003, 0.001, 0), 0.11);
  hit.region = Region::box(Vec3d(-1, -1, 0.04), Vec3d(1, 1, 1));
  run.go({hit});
  EXPECT_EQ(run.momentum(run.states[4]).norm(), 0);
  EXPECT_LT((run.momentum(run.states[5]) - hit.vector).norm(), 1e-12 * hit.vector.norm());
  EXPECT_LT((run.momentum(run.states.back()) - hit.vector).norm(), 1e-11 * hit.vector.norm());
}

TEST(Interaction, AnImpulseActsInExactlyOneSubstep) {
  for (const int fps : {24, 25, 30, 50, 60, 120})
    for (int tenths = 0; tenths < 30; ++tenths)
      for (int substeps = 1; substeps < 200; substeps += 3) {
        int acted = 0;
        for (int frame = 0; frame < 4 * fps; ++frame) {
          const double begin = static_cast<double>(frame) / fps, dt = 1.0 / fps / substeps, start = 0.1 * tenths;
          if (begin > start + 0.1 || begin + 0.1 < start) continue;
          for (int k = 0; k < substeps; ++k) acted += starts_within(start, begin + k * dt, dt);
        }
        ASSERT_EQ(acted, 1) << fps << " fps, " << tenths << " tenths, " << substeps << " substeps";
      }
}

TEST(Interaction, GustWithoutRateIsAnAcceleration) {
  Experiment run;
  run.go({make(InteractionType::kGust, Vec3d(1, 0, 2), 0, 0.3)});
  const Vec3d expected = run.particles.total_mass() * 0.3 * Vec3d(1, 0, 2);
  EXPECT_LT((run.momentum(run.states.back()) - expected).norm(), 1e-11 * expected.norm());
}

TEST(Interaction, GustApproachesTheWindExponentially) {
  Experiment run;
  Interaction wind = make(InteractionType::kGust, Vec3d(2, 0, 0));
  wind.rate = 5;
  run.options.substeps = 60;
  run.go({wind});
  for (const State& s : run.states) {
    const Vec3d velocity = run.momentum(s) / run.particles.total_mass();
    EXPECT_NEAR(velocity.x(), 2 * (1 - std::exp(-5 * s.time)), 3e-3) << s.time;
  }
}

TEST(Interaction, GrabBringsTheCentreToItsTarget) {
  Experiment run;
  run.options.duration = 1.0;
  run.particles = fixture::block<double>({0.03, 0.03, 0.1}, 0.01, 1.0, 2e4);
  Interaction pin = make(InteractionType::kPin, Vec3d::Zero());
  pin.region = Region::half_space(Vec3d(0, 0, 0.02), Vec3d(0, 0, 1));
  Interaction grab = make(InteractionType::kGrab, Vec3d::Zero());
  grab.region = Region::sphere(Vec3d(0.015, 0.015, 0.1), 0.025);
  const Vec3d rest = run.centre(initial_state(run.particles), grab.region), target = rest + Vec3d(0.02, 0.01, -0.003);
  grab.path = {{0.0, rest}, {0.3, target}, {1.0, target}};
  grab.stiffness = 2000;
  grab.damping = 20;
  run.options.damping_time = 0.1;
  run.go({pin, grab});
  EXPECT_LT((run.centre(run.states.back(), grab.region) - target).norm(), 0.05 * (target - rest).norm());
}

TEST(Interaction, GrabIsCappedAndEndsWithItsPath) {
  Experiment run;
  Interaction grab = make(InteractionType::kGrab, Vec3d::Zero());
  grab.region = Region::sphere(Vec3d(0.02, 0.02, 0.03), 0.02);
  const Vec3d rest = run.centre(initial_state(run.particles), grab.region);
  grab.path = {{0.0, rest + Vec3d(10, 0, 0)}, {0.2, rest + Vec3d(10, 0, 0)}};
  grab.max_force = 0.05;
  run.go({grab});
  EXPECT_NEAR(run.momentum(run.states[8]).x(), 0.05 * 0.2, 1e-9);
  EXPECT_NEAR(run.momentum(run.states.back()).x(), 0.05 * 0.2, 1e-9);
}

TEST(Interaction, AGrabOrFingerStaysAtTheEndOfItsPathForItsDuration) {
  Experiment run;
  run.options.substeps = 60;
  const auto given = [&](Interaction it, const std::vector<double>& times, double duration) {
    const Vec3d place = it.path[0].position;
    it.path.clear();
    for (const double time : times) it.path.push_back({time, place});
    it.start = 0.1;
    it.duration = duration;
    const auto summary = run.go({it, make(InteractionType::kGust, Vec3d(-1, 0, 0))}).summary;  // against the finger
    Vec3d sum = Vec3d::Zero();
    for (const auto& frame : summary.impulse_of_frame) sum += frame[0];
    return sum;
  };
  Interaction grab = make(InteractionType::kGrab, Vec3d::Zero()), poke = make(InteractionType::kPoke, Vec3d::Zero());
  grab.region = Region::all();
  grab.path = {{0, run.centre(initial_state(run.particles)) + Vec3d(0.05, 0, 0)}};
  poke.region = Region::sphere(Vec3d::Zero(), 0.01);
  poke.path = {{0, Vec3d(-0.012, 0.02, 0.03)}};
  for (const Interaction& it : {grab, poke}) {
    const Vec3d whole = given(it, {0, 0.03}, INFINITY);  // ends with its path
    EXPECT_GT(whole.x(), 1e-5);
    EXPECT_EQ(given(it, {0}, 0.03), whole);
    EXPECT_EQ(given(it, {0, 0.01}, 0.03), whole);
    EXPECT_EQ(given(it, {0, 0.3}, 0.03), whole);
  }
  EXPECT_GT(given(grab, {0}, INFINITY).norm(), 0) << "of one point, to the end";
}

// Half of Young's modulus times the section of a bar of what is touched: a block of 4 x 4 x 6 cm is one of 6 cm.
TEST(Interaction, AGrabPullsNoHarderThanTheTouchedMaterialWithoutALimitOfItsOwn) {
  Experiment run;
  run.particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01, 0.0);
  Interaction grab = make(InteractionType::kGrab, Vec3d::Zero());
  grab.region = Region::all();
  const Vec3d rest = run.centre(initial_state(run.particles));
  grab.path = {{0.0, rest + Vec3d(1e9, 0, 0)}, {0.005, rest + Vec3d(1e9, 0, 0)}};
  run.options.duration = 0.01;
  run.options.fps = 200;
  run.go({grab});
  double volume = 0;
  for (const double v : run.particles.volume) volume += v;
  const double expected = 0.5 * run.particles.young[0] * volume / 0.06 * 0.005;
  EXPECT_NEAR(run.momentum(run.states.back()).x(), expected, 1e-6 * expected);
}

// A spring of 1000 N/m, drawn out by a path of 5 cm at once, pulls with 50 N.
TEST(Interaction, AGrabThatPullsAsHardAsItMayIsSaidWithItsForce) {
  for (const double max_force : {2.0, 500.0}) {
    Experiment run;
    Interaction grab = make(InteractionType::kGrab, Vec3d::Zero());
    grab.region = Region::all();
    const Vec3d place = run.centre(initial_state(run.particles)) + Vec3d(0.05, 0, 0);
    grab.path = {{0.0, place}, {0.2, place}};
    grab.stiffness = 1000;
    grab.max_force = max_force;
    const auto said = std::ranges::count_if(run.go({grab}).summary.warnings, [](const std::string& w) {
      return w.find("interaction 0 (grab) pulls with its maximum force of 2 N") != std::string::npos;
    });
    EXPECT_EQ(said, max_force == 2.0 ? 1 : 0) << max_force;
  }
}

TEST(Interaction, AStretchBeyondTheLawsRangeIsSaidOnce) {
  Experiment run;
  Interaction pin = make(InteractionType::kPin, Vec3d::Zero()), grab = make(InteractionType::kGrab, Vec3d::Zero());
  pin.region = Region::half_space(Vec3d(0, 0, 0.02), Vec3d(0, 0, 1));
  grab.region = Region::half_space(Vec3d(0, 0, 0.045), Vec3d(0, 0, -1));
  const Vec3d rest = run.centre(initial_state(run.particles), grab.region);
  for (const double pull : {0.005, 0.1}) {
    grab.path = {{0.0, rest}, {0.3, rest + Vec3d(0, 0, pull)}, {1.0, rest + Vec3d(0, 0, pull)}};
    grab.max_force = 1e6;
    const auto summary = run.go({pin, grab}).summary;
    const auto said = std::ranges::count_if(
        summary.warnings, [](const std::string& w) { return w.find("times its length") != std::string::npos; });
    EXPECT_EQ(said, pull > 0.05 ? 1 : 0) << pull;
    EXPECT_EQ(summary.max_stretch > kFarStretch, pull > 0.05) << pull << ": " << summary.max_stretch;
  }
}

TEST(Interaction, GravityOfAPinnedBodyActsAsTheDifferenceFromItsRestLoad) {
  Experiment run;
  run.options.gravity = Vec3d(0, 0, -9.81);
  Interaction pin = make(InteractionType::kPin, Vec3d::Zero());
  pin.region = Region::half_space(Vec3d(0, 0, 0.02), Vec3d(0, 0, 1));
  EXPECT_EQ(run.go({pin, make(InteractionType::kGravity, Vec3d(0, 0, -9.81))}).summary.max_displacement, 0);
  EXPECT_GT(run.go({pin, make(InteractionType::kGravity, Vec3d::Zero())}).summary.max_displacement, 1e-4);
  EXPECT_GT(run.centre(run.states.back()).z(), run.centre(run.states.front()).z());  // weightless: it stretches upwards
}

TEST(Interaction, GroundHoldsAFallingBody) {
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    Experiment run;
    run.options.grid = grid;
    run.options.gravity = Vec3d(0, 0, -9.81);
    run.options.duration = 1;
    run.options.damping_time = 0.3;
    run.go({ground(-0.02, 0.5)});
    double lowest = 1;
    for (const Vec3d& x : run.states.back().x) lowest = std::min(lowest, x.z());
    EXPECT_GT(lowest, grid == GridKind::kEulerian ? -0.021 : -0.0215);
    EXPECT_LT(lowest, -0.02 + 0.003);  // it rests on the plane, and not a cell above it
    EXPECT_LT(run.momentum(run.states.back()).norm() / run.particles.total_mass(), 0.02);
  }
}

TEST(Interaction, FrictionStopsASlidingBodyAsCoulombSays) {
  Experiment run;
  run.options.gravity = Vec3d(0, 0, -9.81);
  run.options.duration = 0.4;
  run.particles = fixture::block<double>({0.06, 0.06, 0.03}, 0.01, 1.0, 4e4);
  Interaction hit = make(InteractionType::kImpulse, Vec3d(0.8 * run.particles.total_mass(), 0, 0), 0.15);
  const auto speed_lost = [&](double friction) {
    run.go({ground(0, friction), hit});
    return (run.momentum(run.states[7]) - run.momentum(run.states[15])).x() / run.particles.total_mass();
  };
  const double seconds = 8 / run.options.fps;
  EXPECT_NEAR(speed_lost(0), 0, 1e-10);
  EXPECT_NEAR(speed_lost(0.2), 0.2 * 9.81 * seconds, 0.15 * 0.2 * 9.81 * seconds);
  hit.vector *= 0.3 / 0.8;  // too weak to tip it over its front edge
  run.go({ground(0, INFINITY), hit});
  EXPECT_LT(std::abs(run.momentum(run.states.back()).x()) / run.particles.total_mass(), 0.05 * 0.3 / 0.8);
}

TEST(Interaction, ASeparatingBodyLeavesTheGround) {
  Experiment run;
  run.options.gravity = Vec3d(0, 0, -9.81);
  run.options.duration = 0.2;
  const double mass = run.particles.total_mass();
  run.go({ground(0, 1.0), make(InteractionType::kImpulse, Vec3d(0, 0, 2 * mass))});
  EXPECT_NEAR(run.momentum(run.states.back()).z() / mass, 2 - 9.81 * 0.2, 1e-9);
}

TEST(Interaction, TorqueGivesAngularMomentumAndNoLinear) {
  Experiment run;
  run.options.duration = 0.2;
  Interaction twist = make(InteractionType::kTorque, Vec3d(0, 0, 2e-4), 0, 0.1);
  const auto result = run.go({twist});
  const State& end = run.states.back();
  const Vec3d angular = run.angular(end);
  EXPECT_LT((angular - 0.1 * twist.vector).norm(), 0.01 * angular.norm());
  EXPECT_LT(run.momentum(end).norm(), 1e-12);
  EXPECT_GT(angular.z(), 1e-5);
}

// About any axis, also one that the body does not turn about by itself.
TEST(Interaction, TorqueTimesItsSecondsIsTheAngularMomentumThatItGives) {
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    Experiment run;
    run.particles = fixture::block<double>({0.06, 0.02, 0.02}, 0.01);
    run.options.grid = grid;
    run.options.duration = 0.2;
    for (const bool part : {false, true}) {
      Interaction twist = make(InteractionType::kTorque, Vec3d(2e-6, 2e-6, -1e-6), 0.0137, 0.1);
      if (part) twist.region = Region::sphere(Vec3d(0.06, 0.01, 0.01), 0.03);
      run.go({twist});
      const Vec3d found = run.angular(run.states.back()), expected = 0.1 * twist.vector;
      const double most = grid == GridKind::kEulerian ? 1e-6 : 0.01;
      EXPECT_LT((found - expected).norm(), most * expected.norm()) << found.transpose() << (part ? ", of a part" : "");
      EXPECT_LT(run.momentum(run.states.back()).norm(), 1e-12);
    }
  }
}

TEST(Interaction, WindPressesOnTheAreaThatFacesIt) {
  Experiment run;
  run.options.duration = 0.1;
  // A held wall of 4 x 6 cells: the impulse per second is density / 2 * drag * area * speed^2.
  Interaction wind = make(InteractionType::kWind, Vec3d(8, 0, 0));
  wind.drag_coefficient = 1.3;
  Interaction hold = make(InteractionType::kPin, Vec3d::Zero());
  hold.region = Region::box(Vec3d(-1, -1, -1), Vec3d(1, 1, 1));
  const auto result = run.go({wind, hold});
  const double area = 0.04 * 0.06, expected = 0.5 * 1.2 * 1.3 * area * 64;
  Vec3d given = Vec3d::Zero();
  for (const auto& frame : result.summary.impulse_of_frame) given += frame[0];
  EXPECT_NEAR(given.x() / 0.1, expected, 0.12 * expected);
  EXPECT_LT(std::hypot(given.y(), given.z()), 0.05 * given.x());
  Vec3d held = Vec3d::Zero();
  for (const auto& frame : result.summary.impulse_of_frame) held += frame[1];
  EXPECT_LT((given + held).norm(), 1e-9 * given.norm());  // what holds the wall takes all of it
  // A held leaf of 10 x 10 cells in two layers of drivers, as thick as thin parts are simulated.
  Experiment sheet;
  sheet.options.duration = 0.1;
  sheet.particles = fixture::block<double>({0.005, 0.1, 0.1}, 0.01);
  for (size_t i = 0; i < sheet.particles.size(); ++i)
    sheet.particles.position[i].x() = (Random(3, i).uniform() < 0.5 ? -1 : 1) * kThinCells * 0.01 / std::sqrt(12.0);
  for (double& v : sheet.particles.volume) v *= kThinCells / 0.5;
  given.setZero();
  for (const auto& frame : sheet.go({wind, hold}).summary.impulse_of_frame) given += frame[0];
  const double pressed = 0.5 * 1.2 * 1.3 * 0.1 * 0.1 * 64;
  EXPECT_NEAR(given.x() / 0.1, pressed, 0.12 * pressed);
  // A free body ends up at the speed of the wind, never above it.
  Experiment loose;
  loose.particles = fixture::block<double>({0.04, 0.04, 0.06}, 0.01, 1.0, 1e3, 0.3, 2);
  loose.options.duration = 1;
  loose.go({wind});
  const double speed = loose.momentum(loose.states.back()).x() / loose.particles.total_mass();
  EXPECT_GT(speed, 5);
  EXPECT_LT(speed, 8);
}

TEST(Interaction, AFingerThatTouchesNothingIsReportedWithItsDistance) {
  Experiment run;
  run.options.duration = 0.1;
  Interaction poke = make(InteractionType::kPoke, Vec3d::Zero());
  poke.region = Region::sphere(Vec3d::Zero(), 0.02);
  poke.path = {{0, Vec3d(0.3, 0, 0)}, {0.1, Vec3d(0.21, 0, 0)}};
  const auto warnings = run.go({poke}).summary.warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("0.15"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("touched nothing"), std::string::npos) << warnings[1];
}

TEST(Interaction, AnObstacleOfLessThanThreeCellsIsReportedAndWhyItMayHaveMissed) {
  Experiment run;
  run.options.duration = 0.1;
  Interaction thin = make(InteractionType::kCollider, Vec3d(0, 0, -0.01)), thick = thin;
  thin.region = Region::box(Vec3d(0, 0, 0.1), Vec3d(0.04, 0.04, 0.125));
  thick.region = Region::box(Vec3d(0, 0, 0.1), Vec3d(0.04, 0.04, 0.135));
  const auto warnings = run.go({thin, thick}).summary.warnings;
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_NE(warnings[0].find("interaction 0 (collider) has a half-thickness of only 0.0125 m"), std::string::npos)
      << warnings[0];
  EXPECT_NE(warnings[1].find("interaction 0 (collider) touched nothing: it may be too thin"), std::string::npos);
  EXPECT_EQ(warnings[2], "interaction 1 (collider) touched nothing");
  thin.contact = ContactKind::kSticky;
  EXPECT_EQ(run.go({thin}).summary.warnings.size(), 1u) << "it holds what is near";
}

TEST(Interaction, WhatLeavesTheSpaceOfAnObstacleIsReported) {
  Experiment run;
  run.options.duration = 0.2;
  auto grid = std::make_shared<SignedDistanceGrid>();
  grid->origin = Vec3d(-0.01, -0.01, -0.01);
  grid->spacing = 0.1;
  grid->size = {2, 2, 2};
  grid->value.assign(8, 0.5f);
  Interaction obstacle = make(InteractionType::kCollider, Vec3d::Zero());
  obstacle.distance = grid;
  const auto warnings = [&](double acceleration) {
    return run.go({obstacle, make(InteractionType::kGust, Vec3d(acceleration, 0, 0))}).summary.warnings;
  };
  EXPECT_TRUE(warnings(0.5).empty());
  const std::vector<std::string> left = warnings(5);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_NE(left[0].find("interaction 0 (collider): "), std::string::npos) << left[0];
}

TEST(Interaction, ATurningCollidersSpeedIsThatFarFromItsPivot) {
  const Experiment run;
  Interaction it = make(InteractionType::kCollider, Vec3d::Zero());
  it.angular_velocity = Vec3d(0, 0, 10);
  const auto speed = [&] { return LoadSchedule<double>(run.options, run.particles, {it}).collider_speed(0, 0.01); };
  it.region = Region::sphere(Vec3d(0.1, 0, 0), 0.03);
  it.pivot = it.region.middle();
  EXPECT_NEAR(speed(), 10 * 0.03, 1e-12);
  it.region = Region::box(Vec3d(-2, -0.01, 0), Vec3d(1, 0.01, 0.02));
  it.pivot = Vec3d(-2, 0, 0);
  EXPECT_GT(speed(), 10 * 2.0) << "at the body";
  EXPECT_LT(speed(), 10 * 2.3) << "not at its far end";
  it.region = Region::half_space(Vec3d(0, 0, -0.1), Vec3d(0, 0, 1));
  it.path = {{0, Vec3d(5, 0, 0)}};
  it.pivot = Vec3d(5, 0, 0);
  EXPECT_NEAR(speed(), 10 * 5, 10 * 0.2);
}

TEST(Interaction, WhatBeginsAfterTheClipOrLastsNoTimeIsSaidOnce) {
  Experiment run;
  run.options.duration = 0.1;
  Interaction late = make(InteractionType::kPointForce, Vec3d(1, 0, 0), 0.3), poke;
  poke.type = InteractionType::kPoke;
  poke.region = Region::sphere(Vec3d::Zero(), 0.01);
  poke.path = {{0, Vec3d(0.02, 0.02, 0.07)}, {0.1, Vec3d(0.02, 0.02, 0.065)}};
  poke.start = 2;
  const auto summary = run.go({make(InteractionType::kGust, Vec3d(0.1, 0, 0)), late,
                               make(InteractionType::kImpulse, Vec3d(1, 0, 0), 0.1), poke,
                               make(InteractionType::kPointForce, Vec3d(1, 0, 0), 0.05, 0),
                               make(InteractionType::kImpulse, Vec3d(1e-4, 0, 0), 0.099)})
                           .summary;
  const std::vector<std::string> expected = {
      "interaction 1 (point_force) never acts: it starts at 0.3 s, and the clip ends at 0.1 s",
      "interaction 2 (impulse) never acts: it starts at 0.1 s, and the clip ends at 0.1 s",
      "interaction 3 (poke) never acts: it starts at 2 s, and the clip ends at 0.1 s",
      "interaction 4 (point_force) never acts: it starts at 0.05 s and lasts 0 s"};
  EXPECT_EQ(summary.warnings, expected);
  for (const auto& frame : summary.impulse_of_frame)
    for (const size_t k : {1, 2, 3, 4}) EXPECT_EQ(frame[k], Vec3d::Zero());
}

TEST(Region, SignedDistancesAreThoseOfTheShapes) {
  const Region sphere = Region::sphere(Vec3d(1, 0, 0), 0.5), box = Region::box(Vec3d(0, 0, 0), Vec3d(1, 2, 3)),
               half = Region::half_space(Vec3d(0, 0, 1), Vec3d(0, 0, 2));
  EXPECT_DOUBLE_EQ(sphere.signed_distance(Vec3d(3, 0, 0)), 1.5);
  EXPECT_DOUBLE_EQ(sphere.signed_distance(Vec3d(1, 0, 0)), -0.5);
  EXPECT_DOUBLE_EQ(box.signed_distance(Vec3d(0.5, 1, 1.5)), -0.5);
  EXPECT_DOUBLE_EQ(box.signed_distance(Vec3d(4, 6, 1)), 5);
  EXPECT_DOUBLE_EQ(half.signed_distance(Vec3d(7, 7, 0)), -1);
  EXPECT_TRUE(Region::all().contains(Vec3d(1e9, 0, 0)));
  EXPECT_DOUBLE_EQ(box.scaled(2).signed_distance(Vec3d(8, 12, 2)), 10);
}

TEST(Region, HalfThicknessAndFarthestPointAreThoseOfTheShapes) {
  const Region sphere = Region::sphere(Vec3d(1, 0, 0), 0.5), box = Region::box(Vec3d(0, 0, 0), Vec3d(1, 2, 3)),
               flat = Region::cylinder(Vec3d(0, 0, 0), Vec3d(0, 0, 0.4), 0.3);
  EXPECT_DOUBLE_EQ(sphere.half_thickness(), 0.5);
  EXPECT_DOUBLE_EQ(box.half_thickness(), 0.5);
  EXPECT_DOUBLE_EQ(flat.half_thickness(), 0.2);
  EXPECT_DOUBLE_EQ(sphere.farthest(Vec3d(-1, 0, 0)), 2.5);
  EXPECT_DOUBLE_EQ(box.farthest(Vec3d(1, 2, 0)), std::sqrt(1 + 4 + 9));
  EXPECT_GE(flat.farthest(Vec3d(0, 0, 1)), std::hypot(1, 0.3));
  EXPECT_EQ(box.middle(), Vec3d(0.5, 1, 1.5));
  EXPECT_TRUE(std::isinf(Region::half_space(Vec3d::Zero(), Vec3d::UnitZ()).half_thickness()));
  EXPECT_TRUE(std::isinf(Region::all().farthest(Vec3d::Zero())));
}

TEST(Interaction, NamesFollowTheEnumeration) {
  const auto names = interaction_names();
  ASSERT_EQ(names.size(), 12u);
  EXPECT_EQ(names[static_cast<int>(InteractionType::kGround)], "ground");
  EXPECT_STREQ(interaction_name(InteractionType::kGrab), "grab");
  EXPECT_EQ(names.back(), interaction_name(InteractionType::kWeight));
}

}  // namespace
}  // namespace pliant
