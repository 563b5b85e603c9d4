// A session is the simulation of what was done in it.

#include "physics/simulate/session.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/base/error.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

struct Bar {
  SimulateOptions options;
  Particles particles = fixture::block<float>({0.03, 0.03, 0.08}, 0.01, 0.5, 2e4);
  Interaction pin, grab;

  Bar() {
    options.fps = 100;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.015), Vec3d(0, 0, 1));
    grab.type = InteractionType::kGrab;
    grab.region = Region::sphere(Vec3d(0.015, 0.015, 0.08), 0.02);
  }
  Session session() const { return Session(options, particles, {pin}, initial_state(particles)); }
};

void expect_equal(const SimulationState& a, const SimulationState& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(a.x[i] == b.x[i] && a.v[i] == b.v[i] && a.F[i] == b.F[i]) << i;
}

/// Takes hold in frame 3, pulls until frame 12, lets go.
Vec3d play(Session& session, const Bar& bar, int frames) {
  int grab = -1;
  Vec3d force = Vec3d::Zero();
  for (int f = 0; f < frames; ++f) {
    if (f == 3) grab = session.begin(bar.grab);
    if (f >= 3 && f < 12)
      session.move(grab, session.history()[grab].path.front().position + Vec3d(0.002 * (f - 2), 0, 0));
    if (f == 12) session.end(grab);
    session.advance();
    if (f == 10) force = session.force(grab);
  }
  return force;
}

/// By how much [m] particles of a session are elsewhere than those of a simulation of its history at most, and by how
/// much these have moved.
std::pair<double, double> beside_its_history(const Session& session, const Bar& bar, double duration) {
  SimulateOptions options = bar.options;
  options.duration = duration;
  const auto whole = simulate<float>(options, bar.particles, session.history(), initial_state(bar.particles));
  double largest = 0, moved = 0;
  for (size_t i = 0; i < bar.particles.size(); ++i) {
    largest = std::max<double>(largest, (whole.state.x[i] - session.state().x[i]).norm());
    moved = std::max<double>(moved, (whole.state.x[i] - bar.particles.position[i]).norm());
  }
  return {largest, moved};
}

TEST(Session, WhatWasDoneIsASimulationOfItsHistory) {
  const Bar bar;
  Session session = bar.session();
  const Vec3d force = play(session, bar, 25);
  EXPECT_GT(force.x(), 0.01) << "newtons against the bar's own force";
  ASSERT_EQ(session.history().size(), 2);
  const auto [largest, moved] = beside_its_history(session, bar, 0.25);
  EXPECT_GT(moved, 0.002);
  EXPECT_LT(largest, 1e-3 * moved) << "path, times and force are those of the history";
}

TEST(Session, TheSameAgainGivesTheSameBits) {
  const Bar bar;
  Session first = bar.session(), again = bar.session();
  play(first, bar, 20);
  play(again, bar, 20);
  expect_equal(first.state(), again.state());
}

TEST(Session, APathThatNobodyContinuesStaysAndSoDoesTheHold) {
  const Bar bar;
  Session session = bar.session();
  const int grab = session.begin(bar.grab);
  const Vec3d hold = session.history()[grab].path.front().position;
  session.move(grab, hold + Vec3d(0.01, 0, 0));
  for (int f = 0; f < 60; ++f) session.advance();
  EXPECT_GT(session.force(grab).x(), 0.01);
  session.end(grab);
  EXPECT_EQ(session.force(grab), Vec3d::Zero());
}

TEST(Session, AHandTakesOverAPathWhereItIsThen) {
  const Bar bar;
  Session session = bar.session();
  Interaction grab = bar.grab;
  const Vec3d from(0.015, 0.015, 0.08), far = from + Vec3d(0.02, 0, 0);
  grab.path = {{0, from}, {0.1, far}, {0.5, from}};
  const int number = session.begin(grab);
  for (int f = 0; f < 5; ++f) session.advance();
  session.move(number, from + Vec3d(0, 0.004, 0));
  session.move(number, from + Vec3d(0, 0.005, 0));
  session.advance();
  const auto& path = session.history()[number].path;
  ASSERT_EQ(path.size(), 3u);
  EXPECT_NEAR(path[1].time, 0.05, 1e-12);
  EXPECT_NEAR((path[1].position - (from + Vec3d(0.01, 0, 0))).norm(), 0, 1e-12) << "half the way to the second point";
  EXPECT_NEAR(path[2].time, 0.06, 1e-12);
  EXPECT_EQ(path[2].position, from + Vec3d(0, 0.005, 0));
  for (int f = 0; f < 14; ++f) session.advance();
  EXPECT_NO_THROW(validate_interaction(session.history()[number], 0)) << "times ascend";
  EXPECT_EQ(session.history()[number].path.back().position, path[2].position) << "nothing of the plan is left";
  const auto [largest, moved] = beside_its_history(session, bar, 0.2);
  EXPECT_GT(moved, 5e-4);
  EXPECT_LT(largest, 1e-2 * moved);
}

// Momentum: each of a hundred impulses adds its own, and none is left to be counted.
TEST(Session, AnImpulseEndsWithItsFrameAndASpanWithItsDuration) {
  Bar bar;
  bar.options.gravity = Vec3d::Zero();
  Session session(bar.options, bar.particles, {}, initial_state(bar.particles));
  Interaction push, force;
  push.type = InteractionType::kImpulse;
  push.region = Region::all();
  push.vector = Vec3d(1e-6, 0, 0);
  force.type = InteractionType::kPointForce;
  force.region = Region::all();
  force.vector = Vec3d(0, 1e-3, 0);
  force.duration = 0.025;
  const int span = session.begin(force);
  for (int f = 0; f < 100; ++f) {
    const int number = session.begin(push);
    EXPECT_TRUE(session.acts(number));
    session.advance();
    EXPECT_FALSE(session.acts(number));
    EXPECT_EQ(session.force(number), Vec3d::Zero());
    EXPECT_EQ(session.acts(span), f < 2) << f;
    EXPECT_NEAR(session.force(span).y(), f < 2 ? 1e-3 : 0, 1e-6) << f;
  }
  Vec3d momentum = Vec3d::Zero();
  for (size_t i = 0; i < bar.particles.size(); ++i)
    momentum += static_cast<double>(bar.particles.mass[i]) * session.state().v[i].cast<double>();
  EXPECT_NEAR(momentum.x(), 1e-4, 1e-6);
  EXPECT_NEAR(momentum.y(), 2.5e-5, 1e-6);
}

TEST(Session, AHeldPinCanBeLetGoAndAnErrorLeavesTheSessionAsItWas) {
  Bar bar;
  Session session = bar.session();
  session.advance();
  const Vec3f before = session.state().x[0];
  Interaction nowhere = bar.grab;
  nowhere.region = Region::sphere(Vec3d(9, 9, 9), 0.1);
  EXPECT_THROW(session.begin(nowhere), Error);
  EXPECT_EQ(session.history().size(), 1);
  EXPECT_EQ(session.state().x[0], before);
  session.end(0);
  for (int f = 0; f < 20; ++f) session.advance();
  EXPECT_LT(session.state().x[0].z(), before.z() - 0.1f) << "it falls 0.2 m in 0.2 s";
}

TEST(Session, WhatWasHeldAsItWasCapturedStaysInEquilibriumWhenHeldElsewhere) {
  const Bar bar;
  Session session = bar.session();
  Interaction top = bar.pin;
  top.region = Region::half_space(Vec3d(0, 0, 0.065), Vec3d(0, 0, -1));
  session.advance();
  session.begin(top);
  session.end(0);
  for (int f = 0; f < 30; ++f) session.advance();
  double largest = 0;
  for (size_t i = 0; i < bar.particles.size(); ++i)
    largest = std::max<double>(largest, (session.state().x[i] - bar.particles.position[i]).norm());
  EXPECT_LT(largest, 1e-5) << "gravity would draw it out by some tenths of a millimetre";
}

/// Upward force [N] of a pin at the top of the bar, once all is at rest, where it begins before some frame and what
/// holds the foot was let go one frame before, if anything did.
double force_of_pin_from(int frame, bool held) {
  Bar bar;
  bar.options.damping_time = 0.05;
  Session session = held ? bar.session() : Session(bar.options, bar.particles, {}, initial_state(bar.particles));
  Interaction top = bar.pin;
  top.region = Region::half_space(Vec3d(0, 0, 0.065), Vec3d(0, 0, -1));
  int number = -1;
  for (int f = 0; f < 100; ++f) {
    if (held && f + 1 == frame) session.end(0);
    if (f == frame) number = session.begin(top);
    session.advance();
  }
  return session.force(number).z();
}

// Equilibrium: a pin carries the weight of what nothing held as it was captured, and nothing of what was held, whenever
// it begins and however strong the damping is.
TEST(Session, WhatHeldTheBodyAsItWasCapturedSaysWhetherALaterPinCarriesItsWeight) {
  const double weight = 9.81 * Bar().particles.total_mass();
  for (const int frame : {0, 1, 2}) {
    EXPECT_NEAR(force_of_pin_from(frame, false), weight, 1e-3 * weight) << frame;
    if (frame > 0) EXPECT_NEAR(force_of_pin_from(frame, true), 0, 1e-3 * weight) << frame;
  }
}

// In the middle of a motion: a pin before the first frame holds its particles where they are, not where they were at
// rest, 3 cm beside.
TEST(Session, APinBeforeTheFirstFrameHoldsThingsWhereTheyAre) {
  Bar bar;
  bar.options.gravity = Vec3d::Zero();
  SimulationState start = initial_state(bar.particles);
  for (Vec3f& x : start.x) x.x() += 0.03f;
  Session session(bar.options, bar.particles, {}, start);
  session.begin(bar.pin);
  session.advance();
  for (size_t i = 0; i < start.size(); ++i) ASSERT_LT((session.state().x[i] - start.x[i]).norm(), 1e-5f) << i;
}

TEST(Session, AFrameThatNeedsTooManySubstepsFailsAtOnceAndLeavesTheState) {
  Bar bar;
  bar.options.max_substeps = 40;
  Session session = bar.session();
  session.advance();
  const SimulationState before = session.state();
  session.set({1e4, 0, bar.options.gravity});
  EXPECT_THROW(session.advance(), Error);
  expect_equal(session.state(), before);
  session.set({1, 0, bar.options.gravity});
  EXPECT_NO_THROW(session.advance());
}

TEST(Session, SofterAreAllModuliOfTheLaw) {
  for (const Law law : {Law::kFluid, Law::kViscoelastic}) {
    Bar bar;
    Material& material = bar.particles.materials[0];
    material.law = law;
    material.bulk_modulus = 3e4;
    material.branch_shear = 1e4;
    material.branch_lambda = 2e4;
    material.branch_viscosity = 500;
    Bar soft = bar;
    for (float& young : soft.particles.young) young = static_cast<float>(0.1 * young);
    for (const auto modulus :
         {&Material::bulk_modulus, &Material::branch_shear, &Material::branch_lambda, &Material::branch_viscosity})
      soft.particles.materials[0].*modulus *= 0.1;
    Session session = bar.session(), expected = soft.session(), stiff = bar.session();
    session.set({0.1, 0, bar.options.gravity});
    for (Session* each : {&session, &expected, &stiff}) play(*each, bar, 20);
    expect_equal(session.state(), expected.state());
    EXPECT_NE(session.state().x, stiff.state().x);
  }
}

// A block flies against a finger that stays where it is.
TEST(Session, AFingerThatStaysTakesNoMorePathAndActsAsOnePlannedPointByPoint) {
  constexpr int kFrames = 1000;
  Bar bar;
  bar.options.gravity = Vec3d::Zero();
  bar.particles = fixture::block<float>({0.02, 0.02, 0.02}, 0.01, 0.5, 1e3);
  Interaction finger;
  finger.type = InteractionType::kPoke;
  const Vec3d place(-0.02, 0.01, 0.01);
  finger.region = Region::sphere(place, 0.015);
  finger.path = {{0, place}};
  SimulationState start = initial_state(bar.particles);
  std::fill(start.v.begin(), start.v.end(), Vec3f(-0.05f, 0, 0));
  Session idle(bar.options, bar.particles, {finger}, start);
  for (int f = 0; f < kFrames; ++f) finger.path.push_back({(f + 1) / bar.options.fps, place});
  Session planned(bar.options, bar.particles, {finger}, start);
  for (int f = 0; f < kFrames; ++f) {
    idle.advance();
    planned.advance();
  }
  expect_equal(idle.state(), planned.state());
  EXPECT_GT(idle.state().x[0].x() - start.x[0].x(), -0.25f) << "0.5 m without the finger";
  EXPECT_LE(idle.history()[0].path.size(), 3u);
  EXPECT_NEAR(idle.history()[0].path.back().time, kFrames / bar.options.fps, 1e-9);
}

/// A block of 0.04 m that has fallen asleep on a ground.
Session sleeper(const Interaction& ground) {
  SimulateOptions options;
  options.fps = 100;
  options.sleep_speed = 0.5;
  const Particles block = fixture::block<float>({0.04, 0.04, 0.04}, 0.01, 0.5, 2e4);
  return Session(options, block, {ground}, initial_state(block));
}

void fall_asleep(Session& session) {
  const auto awake = [&] {
    const std::vector<float>& quiet = session.state().quiet_time;
    return quiet.empty() || *std::min_element(quiet.begin(), quiet.end()) < 0.1f;
  };
  session.advance();
  for (int f = 0; f < 200 && awake(); ++f) session.advance();
  ASSERT_FALSE(awake());
}

/// Mean height of the particles [m].
float height(const Session& session) {
  float sum = 0;
  for (const Vec3f& x : session.state().x) sum += x.z();
  return sum / static_cast<float>(session.state().size());
}

/// By how much they rise in 0.2 s.
float rise(Session& session) {
  const float before = height(session);
  for (int f = 0; f < 20; ++f) session.advance();
  return height(session) - before;
}

// Free fall of 0.2 s: g t^2 / 2.
TEST(Session, WhatSleepsNoticesThatWhatHeldItIsGoneAndThatGravityAndStiffnessAreOthers) {
  constexpr float kWay = 0.2f * 0.2f / 2;
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.region = Region::half_space(Vec3d::Zero(), Vec3d::UnitZ());
  {
    Session session = sleeper(ground);
    fall_asleep(session);
    session.end(0);
    EXPECT_NEAR(rise(session), -9.81f * kWay, 0.02f);
  }
  {
    Session session = sleeper(ground);
    fall_asleep(session);
    session.set({1, 0, Vec3d(0, 0, 10)});
    EXPECT_NEAR(rise(session), 10 * kWay, 0.02f);
  }
  {
    Session session = sleeper(ground);
    fall_asleep(session);
    session.set({0.1, 0, Vec3d(0, 0, -9.81)});
    const float before = height(session);
    float lowest = before;
    for (int f = 0; f < 20; ++f) {
      session.advance();
      lowest = std::min(lowest, height(session));
    }
    EXPECT_LT(lowest, before - 1e-3f) << "its weight lowers its middle by rho g h^2 / 3 E = 2.6 mm";
  }
  {
    Session session = sleeper(ground);
    fall_asleep(session);
    Interaction pin;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.1), Vec3d::UnitZ());
    const int hold = session.begin(pin);
    session.end(0);
    fall_asleep(session);
    session.end(hold);
    EXPECT_NEAR(rise(session), -9.81f * kWay, 0.02f);
  }
}

TEST(Session, ASofterBodyGivesMore) {
  const Bar bar;
  double reached[2];
  for (const int soft : {0, 1}) {
    Session session = bar.session();
    session.set({soft ? 0.1 : 1.0, 0.1, bar.options.gravity + Vec3d(0.5, 0, 0)});
    for (int f = 0; f < 200; ++f) session.advance();
    double sum = 0;
    for (size_t i = 0; i < bar.particles.size(); ++i) sum += session.state().x[i].x() - bar.particles.position[i].x();
    reached[soft] = sum;
  }
  EXPECT_NEAR(reached[1] / reached[0], 10, 1.5) << "deflection goes with 1 / E";
}

}  // namespace
}  // namespace pliant
