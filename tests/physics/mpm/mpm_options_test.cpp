// The transfer that keeps what the grid cannot represent, and blocks that sleep.

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "physics/mpm/mpm.h"
#include "physics/simulate/simulate.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

/// First bending mode of a clamped beam, 4 cells thick, started with the velocities of the mode.
struct Swing {
  double decrement;  ///< logarithm of the ratio of two successive peaks on one side
  double noise;      ///< part of the velocities that no affine field per cell explains, over all of them
};

Swing swing(double flip_time) {
  const double dx = 0.01, height = 4 * dx, length = 20 * dx, foot = 2 * dx, young = 1e5;
  const BasicParticles<float> p = fixture::block<float>({length + foot, height, height}, dx, 1.0, young, 0.3, 1000);
  BasicSimulationState<float> state = initial_state(p);
  const double beta = 1.8751041 / length, sigma = 0.7340955, size = 0.05;
  for (size_t i = 0; i < p.size(); ++i) {
    const double s = beta * std::max(0.0, p.position[i].x() - foot), z = p.position[i].z() - 0.5 * height;
    const double shape = std::cosh(s) - std::cos(s) - sigma * (std::sinh(s) - std::sin(s));
    const double slope = beta * (std::sinh(s) + std::sin(s) - sigma * (std::cosh(s) - std::cos(s)));
    state.v[i] = (size * Vec3d(-z * slope, 0, shape)).cast<float>();
  }
  Mpm<float> solver(p, dx, Vec3d(foot + 0.25 * dx, 0, 0), {.flip_time = flip_time});
  solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
  StepLoads<float> loads;
  loads.pins.push_back(Region::half_space(Vec3d(foot, 0, 0), Vec3d(1, 0, 0)));
  const double dt = 0.2 * dx / std::sqrt(1.35 * young / 1000);
  const double period = 2 * 3.14159265358979324 / (beta * beta * std::sqrt(young / 1000 * height * height / 12));
  std::vector<int> tip;
  for (size_t i = 0; i < p.size(); ++i)
    if (p.position[i].x() > foot + length - dx) tip.push_back(static_cast<int>(i));
  const double start = solver.motion_of(tip).centre.z();
  // Extrema between zero crossings, the first of which still contains other modes.
  std::vector<double> extremum = {0};
  EXPECT_TRUE(solver.advance(
      static_cast<int>(2 * period / dt), static_cast<float>(dt), loads,
      [&](int) {
        const double z = solver.motion_of(tip).centre.z() - start;
        if (z * extremum.back() < 0 && std::abs(z) > 1e-4) extremum.push_back(z);
        if (std::abs(z) > std::abs(extremum.back())) extremum.back() = z;
      },
      [] { return true; }));
  EXPECT_GE(extremum.size(), 4u);

  solver.store(state);
  struct Cell {
    int count = 0;
    Vec3d x = Vec3d::Zero(), v = Vec3d::Zero();
    Mat3d C = Mat3d::Zero();
  };
  std::map<std::tuple<int, int, int>, Cell> cells;
  const auto cell_of = [&](const Vec3<float>& x) -> Cell& {
    const auto along = [&](int a) { return static_cast<int>(std::floor(x[a] / dx)); };
    return cells[{along(0), along(1), along(2)}];
  };
  for (size_t i = 0; i < p.size(); ++i) {
    Cell& c = cell_of(state.x[i]);
    ++c.count;
    c.x += state.x[i].cast<double>();
    c.v += state.v[i].cast<double>();
    c.C += state.C[i].cast<double>();
  }
  double rough = 0, all = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const Cell& c = cell_of(state.x[i]);
    const Vec3d v = state.v[i].cast<double>(), d = state.x[i].cast<double>() - c.x / c.count;
    rough += (v - c.v / c.count - c.C / c.count * d).squaredNorm();
    all += v.squaredNorm();
  }
  return {std::log(extremum[1] / extremum[3]), std::sqrt(rough / all)};
}

TEST(FlipBlend, HalvesTheNumericalDampingOfBendingWithoutNoise) {
  const Swing apic = swing(0), blend = swing(0.1);
  RecordProperty("apic", std::to_string(apic.decrement));
  RecordProperty("blend", std::to_string(blend.decrement));
  EXPECT_LT(blend.decrement, 0.5 * apic.decrement);
  EXPECT_GT(blend.decrement, -0.01);
  EXPECT_LT(blend.noise, 0.05);
}

TEST(FlipBlend, WithoutFlowTheTotalDeformationIsTheElasticOne) {
  BasicParticles<double> p = fixture::block<double>(Vec3d::Constant(0.03), 0.01, 0.8, 2e4);
  Material metal;
  metal.law = Law::kMetal;
  metal.yield_stress = 1e9;
  p.materials = {metal};
  auto start = initial_state(p);
  for (size_t i = 0; i < p.size(); ++i)
    for (int a = 0; a < 3; ++a) start.v[i][a] = 0.3 * Random(9, i).normal() + 20 * p.position[i][(a + 1) % 3];
  SimulateOptions options;
  options.duration = 0.1;
  options.flip_time = 0.05;
  const auto end = simulate<double>(options, p, {}, start).state;
  double worst = 0, moved = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    worst = std::max(worst, (end.memory[i].F_total - end.F[i]).norm());
    moved = std::max(moved, (end.F[i] - Mat3d::Identity()).norm());
  }
  EXPECT_GT(moved, 0.1);
  EXPECT_LT(worst, 1e-10);
}

/// Two blocks apart, the second of which flies towards the first.
struct Pair {
  BasicParticles<float> particles;
  BasicSimulationState<float> state;
  std::vector<int> resting;

  explicit Pair(double gap) {
    const BasicParticles<float> one = fixture::block<float>({0.08, 0.08, 0.08}, 0.01, 1.0, 1e5);
    particles = one;
    for (size_t i = 0; i < one.size(); ++i) {
      resting.push_back(static_cast<int>(i));
      particles.position.push_back(one.position[i] + Vec3<float>(static_cast<float>(0.08 + gap), 0, 0));
      for (auto* field : {&particles.volume, &particles.mass, &particles.young, &particles.poisson})
        field->push_back((*field)[i]);
    }
    state = initial_state(particles);
    for (size_t i = one.size(); i < particles.size(); ++i) state.v[i].x() = -2;
  }
};

TEST(Sleep, ABlockAtRestCostsNothingUntilItIsTouched) {
  const double dt = 2e-4;
  Pair pair(0.16);
  const int64_t each = static_cast<int64_t>(pair.resting.size());
  StepLoads<float> none;
  double momentum[2];
  for (const bool sleeping : {false, true}) {
    MpmOptions options;
    if (sleeping) {
      options.sleep_speed = 1e-3;
      options.sleep_time = 0.01;
    }
    Mpm<float> solver(pair.particles, 0.01, Vec3d::Zero(), options);
    solver.load(pair.state, Vec3d::Constant(-1), Vec3d::Constant(1));
    const auto advance = [&](int steps) {
      const int64_t before = solver.particle_updates();
      EXPECT_TRUE(solver.advance(
          steps, static_cast<float>(dt), none, [](int) {}, [] { return true; }));
      return solver.particle_updates() - before;
    };
    advance(100);  // 0.02 s: the gap is still 12 cm
    EXPECT_EQ(advance(50), sleeping ? 50 * each : 100 * each);
    advance(350);  // they have met
    EXPECT_EQ(advance(10), 20 * each);
    momentum[sleeping] = solver.motion_of(pair.resting).velocity.x();
  }
  EXPECT_LT(momentum[1], -0.2);
  EXPECT_NEAR(momentum[1], momentum[0], 1e-3);
}

TEST(Sleep, ALoadAndAChangeOfGravityWake) {
  const double dt = 2e-4;
  Pair pair(0.16);
  for (auto& v : pair.state.v) v.setZero();
  for (const bool by_load : {true, false}) {
    Mpm<float> solver(pair.particles, 0.01, Vec3d::Zero(), {.sleep_speed = 1e-3, .sleep_time = 0.01});
    std::vector<uint32_t> bits(pair.particles.size(), 0);
    for (const int i : pair.resting) bits[i] = 1;
    solver.set_load_bits(bits);
    solver.load(pair.state, Vec3d::Constant(-1), Vec3d::Constant(1));
    StepLoads<float> loads;
    const auto advance = [&](int steps) {
      EXPECT_TRUE(solver.advance(
          steps, static_cast<float>(dt), loads, [](int) {}, [] { return true; }));
    };
    advance(100);
    const int64_t before = solver.particle_updates();
    advance(20);
    EXPECT_EQ(solver.particle_updates(), before);
    if (by_load)
      loads.body.push_back({.bit = 1, .acceleration = Vec3<float>(1, 0, 0)});
    else
      loads.gravity.x() = 1;
    advance(50);
    EXPECT_NEAR(solver.motion_of(pair.resting).velocity.x(), 50 * dt, 1e-5);
  }
}

TEST(Sleep, ContinuesAcrossAStoredState) {
  Pair pair(0.16);
  const int64_t each = static_cast<int64_t>(pair.resting.size());
  const MpmOptions options{.sleep_speed = 1e-3, .sleep_time = 0.01};
  StepLoads<float> none;
  BasicSimulationState<float> middle;
  Mpm<float> first(pair.particles, 0.01, Vec3d::Zero(), options), second(pair.particles, 0.01, Vec3d::Zero(), options);
  first.load(pair.state, Vec3d::Constant(-1), Vec3d::Constant(1));
  first.advance(
      60, 2e-4f, none, [](int) {}, [] { return true; });
  first.store(middle);
  second.load(middle, Vec3d::Constant(-1), Vec3d::Constant(1));
  second.advance(
      20, 2e-4f, none, [](int) {}, [] { return true; });
  EXPECT_EQ(second.particle_updates(), 20 * each);
}

}  // namespace
}  // namespace pliant
