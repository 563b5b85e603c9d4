// Laws of whole simulations, mostly in double on the templates that run in float.

#include "physics/simulate/simulate.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "gaussians/base/error.h"
#include "physics/body/make_particles.h"
#include "physics/laws/law.h"
#include "physics/mpm/mpm.h"
#include "physics/simulate/energy.h"
#include "physics/simulate/loads.h"
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

template <class T>
bool equal(const BasicSimulationState<T>& a, const BasicSimulationState<T>& b) {
  return a.time == b.time && a.frame == b.frame && a.substeps == b.substeps && a.x == b.x && a.v == b.v && a.C == b.C &&
         a.F == b.F;
}

TEST(Simulate, FreeFallFollowsTheSumOfItsSteps) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01);
  State start = initial_state(particles);
  const Vec3d v0(0.3, -0.1, 0.5), g(0.4, 0, -9.81);
  for (auto& v : start.v) v = v0;
  SimulateOptions options = options_of(50, 0.3);
  options.gravity = g;
  const auto result = simulate<double>(options, particles, {}, start, [&](const State& s) {
    const double t = s.time;
    for (size_t i = 0; i < s.size(); ++i) {
      // Substeps differ between frames, so the closed form is summed frame by frame below; here only the velocity.
      EXPECT_LT((s.v[i] - (v0 + g * t)).norm(), 1e-12);
    }
    return true;
  });
  // With one time step throughout, x = x0 + v0 t + g t (t + dt) / 2.
  options.substeps = 40;
  const double dt = 1 / options.fps / options.substeps;
  const auto fixed = simulate<double>(options, particles, {}, start);
  const double t = fixed.state.time;
  EXPECT_DOUBLE_EQ(t, 0.3);
  for (size_t i = 0; i < particles.size(); ++i) {
    const Vec3d expected = particles.position[i] + v0 * t + 0.5 * t * (t + dt) * g;
    ASSERT_LT((fixed.state.x[i] - expected).norm(), 1e-12);
    ASSERT_LT((fixed.state.F[i] - Mat3d::Identity()).norm(), 1e-11);
  }
  EXPECT_EQ(result.summary.strays, 0);
}

TEST(Simulate, ConstantVelocityIsExact) {
  const auto particles = fixture::block<double>({0.03, 0.04, 0.05}, 0.01);
  State start = initial_state(particles);
  const Vec3d v0(0.7, -0.2, 0.1);
  for (auto& v : start.v) v = v0;
  SimulateOptions options = options_of(20, 0.5);
  options.gravity.setZero();
  const auto result = simulate<double>(options, particles, {}, start);
  for (size_t i = 0; i < particles.size(); ++i) {
    ASSERT_LT((result.state.x[i] - particles.position[i] - 0.5 * v0).norm(), 1e-12);
    ASSERT_LT((result.state.v[i] - v0).norm(), 1e-12);
  }
}

TEST(Simulate, RestStaysAtRest) {
  const auto particles = fixture::block<double>({0.03, 0.03, 0.08}, 0.01);
  const auto pinned = simulate<double>(options_of(30, 0.5), particles, {pin_below(0.02)}, initial_state(particles));
  EXPECT_EQ(pinned.summary.max_displacement, 0);
  EXPECT_TRUE(pinned.summary.gravity_cancelled);
  SimulateOptions weightless = options_of(30, 0.5);
  weightless.gravity.setZero();
  EXPECT_EQ(simulate<double>(weightless, particles, {}, initial_state(particles)).summary.max_displacement, 0);
}

TEST(Simulate, APinnedBodySettlesUnderItsGravityWhereItsLawFlows) {
  auto particles = fixture::block<double>({0.03, 0.03, 0.08}, 0.01);
  SimulateOptions options = options_of(30, 0);
  options.settle_time = 0.03;
  for (const Law law : {Law::kNeoHookean, Law::kViscoelastic, Law::kSand, Law::kMetal}) {
    Material& material = particles.materials[0];
    material.law = law;
    material.yield_stress = 1e5;
    material.branch_shear = material.branch_lambda = 1e3;
    material.branch_viscosity = 1e2;
    const auto summary = simulate<double>(options, particles, {pin_below(0.02)}, initial_state(particles)).summary;
    const bool holds = law == Law::kNeoHookean || law == Law::kViscoelastic;
    EXPECT_EQ(summary.gravity_cancelled, holds) << law_name(law);
    EXPECT_EQ(summary.settle_displacement == 0, holds) << law_name(law);
  }
}

TEST(Simulate, PinnedNodesHoldAndAReleasedPinFalls) {
  const auto particles = fixture::block<double>({0.03, 0.03, 0.09}, 0.01);
  std::vector<State> states;
  const auto keep = [&](const State& s) { return states.push_back(s), true; };
  const double release = 0.2;
  simulate<double>(options_of(50, 0.4), particles, {pin_below(0.03, release), gust(Vec3d(2, 0, 0), release)},
                   initial_state(particles), keep);
  double held = 0, deep = 0, top = 0;
  for (size_t i = 0; i < particles.size(); ++i) {
    const double moved = (states[10].x[i] - particles.position[i]).norm();
    if (particles.position[i].z() < 0.005) held = std::max(held, moved);  // a stencil that only sees pinned nodes
    if (particles.position[i].z() < 0.02) deep = std::max(deep, moved);
    top = std::max(top, moved);
  }
  EXPECT_EQ(held, 0);
  EXPECT_LT(deep, 0.01 * top);  // a cell inside the pin
  EXPECT_GT(top, 1e-4);
  // After the release the centre falls as a free body.
  const auto centre_velocity = [&](const State& s) {
    Vec3d sum = Vec3d::Zero();
    for (const Vec3d& v : s.v) sum += v / static_cast<double>(s.size());
    return sum;
  };
  const Vec3d fallen = centre_velocity(states[20]) - centre_velocity(states[10]);
  EXPECT_LT((fallen - Vec3d(0, 0, -9.81 * 0.2)).norm(), 1e-10);
}

TEST(Simulate, AngularAndLinearMomentumOfAFreeBodyAreKept) {
  const auto particles = fixture::block<double>({0.03, 0.03, 0.06}, 0.01);
  State start = initial_state(particles);
  for (size_t i = 0; i < start.size(); ++i)
    start.v[i] = Vec3d(0, 3, 0).cross(start.x[i]) + Vec3d(0.1, 0.5 * start.x[i].z(), 0);
  SimulateOptions options = options_of(30, 0.3);
  options.grid = GridKind::kEulerian;  // see lagrangian_test for the other
  options.gravity.setZero();
  const auto totals = [&](const State& s) {
    Totals t;
    for (size_t i = 0; i < s.size(); ++i) {
      const double m = particles.mass[i], inertia = 0.25 * m * 1e-4;
      t.momentum += m * s.v[i];
      const Mat3d& C = s.C[i];
      t.angular += m * s.x[i].cross(s.v[i]) + inertia * Vec3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
    }
    return t;
  };
  const auto result = simulate<double>(options, particles, {}, start);
  const Totals before = totals(start), after = totals(result.state);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-11 * before.momentum.norm());
  EXPECT_LT((after.angular - before.angular).norm(), 1e-11 * before.angular.norm());
  EXPECT_GT(result.summary.max_displacement, 0.02);
}

TEST(Simulate, TimeCentredEnergyNeverGrows) {
  const auto particles = fixture::block<double>({0.03, 0.03, 0.08}, 0.01);
  State start = initial_state(particles);
  for (size_t i = 0; i < start.size(); ++i)
    start.v[i] = Vec3d(0.5 * start.x[i].z() / 0.08, 0, 0.2 * start.x[i].z() / 0.08);
  // One substep a frame, so that every step is seen: 2e-4 s is a Courant number of 0.29.
  SimulateOptions options = options_of(10000, 0.2);
  options.grid = GridKind::kEulerian;  // see lagrangian_test for the other
  options.substeps = 1;
  double last_potential = 0, last_kinetic = -1, last = 0, first = 0, largest_rise = -1;
  simulate<double>(options, particles, {pin_below(0.01)}, start, [&](const State& s) {
    double potential = elastic_energy(particles, s);
    for (size_t i = 0; i < s.size(); ++i) {  // in the springs of the clamp at z = 1 cm
      if (particles.position[i].z() > 0.01 + kClampReach * 0.01) continue;
      const Lame<double> law = lame(particles.young[i], particles.poisson[i]);
      potential += 0.5 * kClampSpring * (law.lambda + 2 * law.mu) * particles.volume[i] / 1e-4 *
                   (s.x[i] - particles.position[i]).squaredNorm();
    }
    const double kinetic = kinetic_energy(particles, s);
    if (s.frame > 1) {
      // v lies half a step before x: PE_n + (KE_n + KE_n+1) / 2.
      const double energy = last_potential + 0.5 * (last_kinetic + kinetic);
      if (first == 0) {
        first = energy;
        last = energy;
      }
      largest_rise = std::max(largest_rise, energy - last);
      last = energy;
    }
    last_potential = potential;
    last_kinetic = kinetic;
    return true;
  });
  EXPECT_LT(largest_rise, 1e-5 * first);
  EXPECT_LT(last, first);
  EXPECT_GT(last, 0.2 * first);
}

TEST(Simulate, TrajectoriesAreEqualForOneTwoAndFourThreads) {
  const auto particles = fixture::block<float>({0.05, 0.06, 0.18}, 0.01);  // large enough for four
  std::vector<SimulationState> final;
  const int threads = omp_get_max_threads();
  for (const int n : {1, 2, 4}) {
    omp_set_num_threads(n);
    final.push_back(simulate<float>(options_of(30, 0.2), particles, {pin_below(0.02), gust(Vec3d(5, 1, 0))},
                                    initial_state(particles))
                        .state);
  }
  omp_set_num_threads(threads);
  EXPECT_TRUE(equal(final[0], final[1]));
  EXPECT_TRUE(equal(final[0], final[2]));
}

TEST(Simulate, ResumedRunsEqualUnbrokenOnes) {
  const auto particles = fixture::block<float>({0.04, 0.04, 0.1}, 0.01);
  Interaction grab;
  grab.type = InteractionType::kGrab;
  grab.region = Region::sphere(Vec3d(0.02, 0.02, 0.1), 0.02);
  grab.path = {{0, Vec3d(0.02, 0.02, 0.09)}, {0.3, Vec3d(0.05, 0.02, 0.09)}};
  const std::vector<Interaction> script = {pin_below(0.02), gust(Vec3d(5, 1, 0), 0.1), grab};
  SimulationState saved;
  const auto whole =
      simulate<float>(options_of(30, 0.4), particles, script, initial_state(particles), [&](const SimulationState& s) {
        if (s.frame == 5) saved = s;
        return true;
      });
  const auto resumed = simulate<float>(options_of(30, 0.4), particles, script, saved);
  EXPECT_TRUE(equal(whole.state, resumed.state));
  EXPECT_EQ(resumed.summary.frames, whole.summary.frames - 5);
}

/// Mean velocity along z [m/s] at the end of a run in which a body sleeps when something changes after half a second,
/// at a frame border.
double velocity_at_last(const std::vector<Interaction>& script, const Vec3d& gravity = Vec3d(0, 0, -9.81),
                        double damping_time = 0) {
  const auto particles = fixture::block<float>({0.04, 0.04, 0.06}, 0.01, 1.0, 1e5);
  SimulateOptions options = options_of(20, 0.8);
  options.gravity = gravity;
  options.sleep_speed = 0.2;
  options.settle_time = 1;
  options.damping_time = damping_time;
  SimulationState saved;
  const auto whole =
      simulate<float>(options, particles, script, initial_state(particles), [&](const SimulationState& s) {
        if (s.time == 0.5) saved = s;
        return true;
      });
  EXPECT_GE(*std::min_element(saved.quiet_time.begin(), saved.quiet_time.end()), MpmOptions().sleep_time);
  EXPECT_TRUE(equal(whole.state, simulate<float>(options, particles, script, saved).state)) << "resumed at the change";
  double sum = 0;
  for (const Vec3f& v : whole.state.v) sum += v.z() / static_cast<double>(particles.size());
  return sum;
}

TEST(Simulate, WhatChangesAtAFrameBorderWakesWhatSleeps) {
  const double change = 0.5, fallen = -9.81 * 0.3;
  EXPECT_NEAR(velocity_at_last({pin_below(0.03, change)}), fallen, 0.02 * 9.81);
  Interaction weight;
  weight.type = InteractionType::kGravity;
  weight.vector = Vec3d(0, 0, -9.81);
  weight.start = change;
  EXPECT_NEAR(velocity_at_last({weight}, Vec3d::Zero()), fallen, 0.02 * 9.81);
  // One support takes the place of another, which is far below.
  Interaction floor, lower;
  floor.type = lower.type = InteractionType::kGround;
  floor.region = Region::half_space(Vec3d(0, 0, -0.002), Vec3d(0, 0, 1));
  floor.duration = lower.start = change;
  lower.region = Region::half_space(Vec3d(0, 0, -9), Vec3d(0, 0, 1));
  const double damping = 0.3, limit = 0.5 * 9.81 * damping;
  EXPECT_LT(velocity_at_last({floor, lower}, Vec3d(0, 0, -9.81), damping),
            -0.8 * limit * (1 - std::exp(-0.6 / damping)));
}

TEST(Simulate, APinThatBeginsLaterDoesNotCarryTheBodysWeight) {
  const double height = 0.08, young = 1e4, sag = 1000 * 9.81 * height * height / (2 * young);
  const auto particles = fixture::block<double>({0.04, 0.04, height}, 0.01, 1.0, young, 0.0);
  /// How far the top has come down on a ground, with a pin from some time on.
  const auto lowered = [&](double pinned_from) {
    Interaction pin = pin_below(0.02), ground;
    pin.start = pinned_from;
    ground.type = InteractionType::kGround;
    ground.region = Region::half_space(Vec3d(0, 0, -0.002), Vec3d(0, 0, 1));
    SimulateOptions options = options_of(50, 1);
    options.damping_time = 0.05;
    const State end = simulate<double>(options, particles, {ground, pin}, initial_state(particles)).state;
    double sum = 0, count = 0;
    for (size_t i = 0; i < particles.size(); ++i)
      if (particles.position[i].z() > height - 0.01) {
        sum += particles.position[i].z() - end.x[i].z();
        ++count;
      }
    return sum / count;
  };
  EXPECT_EQ(lowered(0), 0) << "captured as its weight has bent it";
  // What is above the pin is still compressed by its weight: nine sixteenths of the sag.
  EXPECT_NEAR(lowered(0.5), lowered(2), 0.15 * sag);
}

TEST(Simulate, ASummaryGoesOnWhereItsFramesDid) {
  const auto particles = fixture::block<float>({0.04, 0.04, 0.04}, 0.01);
  Interaction impulse;
  impulse.type = InteractionType::kImpulse;
  impulse.vector = Vec3d(0.01, 0, 0);
  impulse.start = 0.04;
  impulse.region = Region::all();
  SimulateOptions options = options_of(50, 0.2);
  const auto whole = simulate<float>(options, particles, {impulse}, initial_state(particles)).summary;
  SimulateSummary summary;
  const auto half = simulate<float>(
      options, particles, {impulse}, initial_state(particles),
      [](const SimulationState& state) { return state.frame < 5; }, summary);
  ASSERT_TRUE(half.stopped);
  simulate<float>(options, particles, {impulse}, half.state, {}, summary);
  EXPECT_EQ(summary.frames, whole.frames);
  EXPECT_EQ(summary.substeps_of_frame, whole.substeps_of_frame);
  EXPECT_EQ(summary.impulse_of_frame, whole.impulse_of_frame);
  EXPECT_EQ(summary.max_displacement, whole.max_displacement);
  EXPECT_EQ(summary.warnings, whole.warnings);
}

TEST(Simulate, NothingSettlesWithoutGravity) {
  const auto particles = fixture::block<double>({0.04, 0.04, 0.04}, 0.01);
  SimulateOptions options = options_of(50, 0.1);
  options.gravity.setZero();
  options.settle_time = 2;
  State start = initial_state(particles);
  for (auto& v : start.v) v = Vec3d(0.1, 0, 0);
  const auto result = simulate<double>(options, particles, {}, start);
  EXPECT_EQ(result.summary.settle_seconds, 0);
  EXPECT_TRUE(result.summary.warnings.empty());
  EXPECT_NEAR(result.state.x[0].x() - particles.position[0].x(), 0.01, 1e-9);
}

TEST(Simulate, TheSinkSeesEveryFrameAndCanStop) {
  const auto particles = fixture::block<float>({0.03, 0.03, 0.03}, 0.01);
  int expected = 0;
  auto result =
      simulate<float>(options_of(25, 0.4), particles, {}, initial_state(particles), [&](const SimulationState& s) {
        EXPECT_EQ(s.frame, expected);
        EXPECT_DOUBLE_EQ(s.time, expected / 25.0);
        ++expected;
        return true;
      });
  EXPECT_EQ(expected, 11);
  EXPECT_FALSE(result.stopped);
  result = simulate<float>(options_of(25, 0.4), particles, {}, initial_state(particles),
                           [](const SimulationState& s) { return s.frame < 3; });
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.state.frame, 3);
}

TEST(Simulate, AnOscillationDecaysInTheGivenTime) {
  // First mode of a short bar along z, undamped and with two damping times; the ratio cancels the scheme's own loss.
  const auto particles = fixture::block<double>({0.03, 0.03, 0.08}, 0.01, 0.0);
  State start = initial_state(particles);
  for (size_t i = 0; i < start.size(); ++i) start.v[i].z() = 0.05 * std::sin(1.5707963 * start.x[i].z() / 0.08);
  const auto amplitude = [&](double damping_time, double viscosity_time) {
    SimulateOptions options = options_of(400, 0.3);
    options.damping_time = damping_time;
    options.viscosity_time = viscosity_time;
    options.substeps = 8;
    double peak = 0;
    simulate<double>(options, particles, {pin_below(0.0)}, start, [&](const State& s) {
      if (s.time > 0.2) peak = std::max(peak, std::abs(s.x.back().z() - particles.position.back().z()));
      return true;
    });
    return peak;
  };
  const double free = amplitude(0, 0);
  EXPECT_NEAR(std::log(free / amplitude(0.1, 0)), 2.4, 0.4);  // about t / tau, the peak lying in 0.2 .. 0.3 s
  const double weak = std::log(free / amplitude(0, 0.0005)), strong = std::log(free / amplitude(0, 0.001));
  EXPECT_GT(weak, 0.1);
  EXPECT_NEAR(strong / weak, 2, 0.25);  // the decay rate grows with the viscosity time
}

}  // namespace
}  // namespace pliant
