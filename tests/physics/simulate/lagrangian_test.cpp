// Elastic bodies on a Lagrangian grid neither tear nor forget their shape; beside the Eulerian grid where that says
// something.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "gaussians/base/error.h"
#include "physics/simulate/energy.h"
#include "physics/simulate/simulator.h"
#include "tests/physics/shapes.h"
#include "tests/physics/simulate/recorded_motion.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

using fixture::Motion;
using fixture::pin_left;
using State = Motion::State;
constexpr double kPi = 3.14159265358979324;

}  // namespace

// Patch test: an affine motion is an exact solution, so that uniformly strained matter in the middle of a body feels no
// force, and a velocity that is affine in the rest position strains it exactly.
TEST(Lagrangian, UniformStrainIsInEquilibriumAndAnAffineVelocityStrainsExactly) {
  const Mat3d A = (Mat3d() << 1.2, 0.1, -0.05, 0.02, 0.9, 0.1, 0.03, -0.08, 1.1).finished();
  Motion regular(Vec3d::Constant(0.12), 0.01, 0, GridKind::kLagrangian);
  regular.options.substeps = 1;
  regular.options.fps = 1e4;
  regular.go(1e-4, regular.deformed([&](const Vec3d& X) { return A * X; }, [&](const Vec3d&) { return A; }));
  double middle = 0, surface = 0;
  for (size_t i = 0; i < regular.particles.size(); ++i) {
    const Vec3d inside = (regular.particles.position[i].array() - 0.06).abs();
    (inside.maxCoeff() < 0.02 ? middle : surface) =
        std::max(inside.maxCoeff() < 0.02 ? middle : surface, regular.states.back().v[i].norm());
  }
  EXPECT_LT(middle, 1e-12 * surface);

  Motion uneven(Vec3d::Constant(0.06), 0.01, 1, GridKind::kLagrangian);
  uneven.options.substeps = 1;
  uneven.options.fps = 1e6;
  const Mat3d L = (Mat3d() << 3, 1, -2, 0.5, -1, 2, 1, 1, 0.3).finished();
  State start = initial_state(uneven.particles);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = L * start.x[i] + Vec3d(1, 2, 3);
    start.C[i] = L;
  }
  uneven.go(1e-6, start);
  for (const Mat3d& F : uneven.states.back().F) EXPECT_LT((F - Mat3d::Identity() - 1e-6 * L).norm(), 1e-15);
}

TEST(Lagrangian, AFreeSpinKeepsItsAngularMomentumForTenTurns) {
  Motion spin(Vec3d(0.08, 0.03, 0.03), 0.01, 1, GridKind::kLagrangian);
  const double omega = 2 * kPi * 5;
  State start = initial_state(spin.particles);
  const Vec3d middle = spin.centre(start), axis(0, 0, omega);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = axis.cross(Vec3d(start.x[i] - middle));
    start.C[i] << 0, -omega, 0, omega, 0, 0, 0, 0, 0;
  }
  spin.states = {start};
  SimulateSummary summary;
  Simulator<double> simulator(spin.options, spin.particles, {}, summary);
  std::vector<Vec3d> angular;
  for (State state = start; state.time < 2.0;) {
    simulator.advance(state);
    spin.states.push_back(state);
    angular.push_back(simulator.solver().grid_totals(true).angular);
  }
  EXPECT_LT((angular.back() - angular.front()).norm(), 1e-10 * angular.front().norm());
  EXPECT_LT((spin.centre(spin.states.back()) - middle).norm(), 1e-9);
  // Half a turn is opposite, and it is as long as the centrifugal force makes it.
  EXPECT_GT((spin.states[5].x[0] - start.x[0]).norm(), 1.9 * (start.x[0] - middle).norm());
  EXPECT_LT(spin.distance_from_rest(spin.states.back()), 0.001);
}

// Half a step apart, places and velocities keep an energy near the true one, whose error does not grow (symplectic
// Euler).
class LagrangianLaws : public ::testing::TestWithParam<Law> {};
INSTANTIATE_TEST_SUITE_P(Elastic, LagrangianLaws,
                         ::testing::Values(Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky),
                         [](const auto& info) { return std::string(law_name(info.param)); });

TEST_P(LagrangianLaws, EnergyOfAFreeSwingStaysWithinAPermille) {
  Motion bar(Vec3d(0.03, 0.03, 0.08), 0.01, 1, GridKind::kLagrangian);
  bar.particles.materials[0].law = GetParam();
  bar.options.fps = 10000;
  bar.options.substeps = 1;
  State start = initial_state(bar.particles);
  for (size_t i = 0; i < start.size(); ++i) {
    start.v[i] = Vec3d(0.5, 0, 0.2) * start.x[i].z() / 0.08;
    start.C[i] << 0, 0, 0.5 / 0.08, 0, 0, 0, 0, 0, 0.2 / 0.08;
  }
  SimulateSummary summary;
  Simulator<double> simulator(bar.options, bar.particles, {}, summary);
  std::vector<double> energy;
  double last_potential = 0, last_kinetic = 0, least_kinetic = INFINITY;
  for (State state = start; state.frame < 2000;) {
    simulator.advance(state);
    const auto nodes = simulator.solver().node_energy();
    const double potential = elastic_energy(bar.particles, state) + nodes.stabilization;
    if (state.frame > 1) energy.push_back(last_potential + 0.5 * (last_kinetic + nodes.kinetic));
    last_potential = potential;
    last_kinetic = nodes.kinetic;
    least_kinetic = std::min(least_kinetic, nodes.kinetic);
  }
  const auto [low, high] = std::minmax_element(energy.begin(), energy.end());
  EXPECT_LT(*high - *low, 1e-3 * *high);
  EXPECT_LT(least_kinetic, 0.96 * *high) << "it swings";
}

TEST(Lagrangian, ABarBentIntoARingAndLetGoIsStraightAgain) {
  const double length = 0.24, radius = length / (2 * kPi);
  Motion bar(Vec3d(length, 0.02, 0.02), 0.01, 1, GridKind::kLagrangian);
  bar.options.damping_time = 0.2;
  // Its middle line becomes a circle; cross sections stay plane.
  const auto angle = [&](const Vec3d& X) { return X.x() / radius; };
  const auto place = [&](const Vec3d& X) {
    const double r = radius - (X.z() - 0.01), a = angle(X);
    return Vec3d(r * std::sin(a), X.y(), radius - r * std::cos(a));
  };
  const auto F = [&](const Vec3d& X) {
    const double r = radius - (X.z() - 0.01), a = angle(X);
    Mat3d f = Mat3d::Identity();
    f.col(0) = r / radius * Vec3d(std::cos(a), 0, std::sin(a));
    f.col(2) = Vec3d(-std::sin(a), 0, std::cos(a));
    return f;
  };
  bar.go(4.0, bar.deformed(place, F));
  EXPECT_GT(bar.distance_from_rest(bar.states.front()), 0.3 * length);
  // Places and deformation of the start belong together up to the grid's resolution, and so do those of the end.
  EXPECT_LT(bar.distance_from_rest(bar.states.back()), 2e-3 * length);
}

TEST(Lagrangian, APulledStripStaysWholeAndStraightAndComesBackAndOnAnEulerianGridItTears) {
  const double length = 0.12;
  double reached[2], left[2], aside[2];
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    Motion strip(Vec3d(length, 0.02, 0.01), 0.01, 1, grid);
    strip.options.damping_time = 0.15;
    Interaction grab;
    grab.type = InteractionType::kGrab;
    grab.region = Region::sphere(Vec3d(length, 0.01, 0.005), 0.015);
    Vec3d rest = Vec3d::Zero();
    double mass = 0;
    for (size_t i = 0; i < strip.particles.size(); ++i)
      if (grab.region.contains(strip.particles.position[i])) {
        rest += strip.particles.mass[i] * strip.particles.position[i];
        mass += strip.particles.mass[i];
      }
    rest /= mass;
    const Vec3d far = rest + Vec3d(2.4 * length, 0, 0);
    grab.path = {{0.0, rest}, {1.0, far}, {3.0, rest}};
    grab.duration = 3;
    grab.stiffness = 2000;
    grab.max_force = 500;  // the default would stretch it less
    strip.script = {pin_left(0.01), grab};
    strip.go(4.0, initial_state(strip.particles));
    const int k = grid == GridKind::kLagrangian;
    reached[k] = left[k] = aside[k] = 0;
    for (size_t i = 0; i < strip.particles.size(); ++i) {
      const Vec3d &X = strip.particles.position[i], &pulled = strip.states[50].x[i], &end = strip.states.back().x[i];
      reached[k] = std::max(reached[k], pulled.x() / length);
      aside[k] = std::max(aside[k], (pulled - X).tail<2>().norm() / length);
      left[k] = std::max(left[k], (end - X).norm() / length);
    }
  }
  EXPECT_GT(reached[1], 3.0);
  EXPECT_LT(aside[1], 0.06) << "its width shrinks, but it does not turn";
  EXPECT_LT(left[1], 1e-4) << "back where it was";
  EXPECT_GT(left[0], 0.2) << "the Eulerian grid tears it";
  RecordProperty("stretched_to_lengths", std::to_string(reached[1]));
  RecordProperty("left_of_length", std::to_string(left[1]));
  RecordProperty("left_of_length_eulerian", std::to_string(left[0]));
}

// Two leaves, three tenths of a cell apart at rest, of which one is pulled away by three cells.
TEST(Lagrangian, PartsThatDoNotHangTogetherMoveApartHoweverNearTheyAre) {
  fixture::TwoLeaves leaves;
  const BasicParticles<double>& p = leaves.particles;
  const size_t one = leaves.one;
  const auto moved = [&](size_t from, size_t to) {
    double most = 0;
    for (size_t i = from; i < to; ++i) most = std::max(most, (leaves.states.back().x[i] - p.position[i]).norm());
    return most / p.cell_size;
  };
  leaves.move_upper(3);
  EXPECT_GT(moved(0, one), 2) << "nodes in common glue them together";
  leaves.link();
  leaves.move_upper(3);
  EXPECT_LT(moved(0, one), 0.01);
  EXPECT_GT(moved(one, p.size()), 2.9);
  RecordProperty("other_leaf_moved_cells", std::to_string(moved(0, one)));

  // And it moves as if the other one were not there but for the contact with it: what hangs together is as stiff as
  // without links.
  fixture::TwoLeaves alone;
  alone.drop_lower();
  alone.move_upper(3);
  double most = 0;
  for (size_t i = one; i < p.size(); ++i)
    most = std::max(most, (leaves.states.back().x[i] - alone.states.back().x[i - one]).norm());
  EXPECT_LT(most, 0.1 * p.cell_size);
}

// Similarity: density and stiffness times the same number give the same motion in the same substeps, be it grams or
// tons.
TEST(Lagrangian, MotionDoesNotDependOnTheUnitOfMass) {
  const auto swing = [](double factor, SimulateSummary& summary) {
    const Particles particles = fixture::block<float>({0.2, 0.2, 0.8}, 0.1, 0.5, 2e4 * factor, 0.3, 500 * factor);
    Interaction pin, tilt;
    pin.type = InteractionType::kPin;
    pin.region = Region::half_space(Vec3d(0, 0, 0.15), Vec3d(0, 0, 1));
    tilt.type = InteractionType::kGravity;
    tilt.vector = {3, 0, -9};
    SimulateOptions options;
    options.grid = GridKind::kLagrangian;
    options.fps = 30;
    SimulationState state = initial_state(particles);
    Simulator<float> simulator(options, particles, {pin, tilt}, summary);
    for (int f = 0; f < 15; ++f) simulator.advance(state);
    return state;
  };
  SimulateSummary light, heavy;
  const SimulationState a = swing(1, light), b = swing(1e6, heavy);
  EXPECT_EQ(light.substeps_of_frame, heavy.substeps_of_frame);
  EXPECT_EQ(heavy.retries, 0);
  float moved = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    moved = std::max(moved, a.x[i].x() - 0.2f);
    ASSERT_LT((a.x[i] - b.x[i]).norm(), 1e-5f);
  }
  EXPECT_GT(moved, 0.01f);
}

// The Eulerian grid takes the Cauchy stress of a law, this one its first Piola-Kirchhoff stress.
TEST_P(LagrangianLaws, MoveAsOnTheEulerianGrid) {
  std::vector<std::vector<Vec3d>> ends;
  double moved = 0, apart = 0;
  for (const GridKind grid : {GridKind::kEulerian, GridKind::kLagrangian}) {
    Motion bar(Vec3d(0.12, 0.03, 0.03), 0.01, 0.5, grid);
    bar.particles.materials[0].law = GetParam();
    Interaction push;
    push.type = InteractionType::kGust;
    push.vector = Vec3d(0, 0, -9.81);
    bar.script = {pin_left(0.015), push};
    bar.go(0.06, initial_state(bar.particles));
    ends.push_back(bar.states.back().x);
    for (size_t i = 0; i < bar.particles.size(); ++i)
      moved = std::max(moved, (ends.back()[i] - bar.particles.position[i]).norm());
  }
  for (size_t i = 0; i < ends[0].size(); ++i) apart = std::max(apart, (ends[0][i] - ends[1][i]).norm());
  EXPECT_GT(moved, 0.003);
  EXPECT_LT(apart, 0.05 * moved);
}

TEST(Lagrangian, IsRefusedWhereThereIsNoReferenceShape) {
  Motion sand(Vec3d::Constant(0.02), 0.01, 1, GridKind::kLagrangian);
  sand.particles.materials[0].law = Law::kSand;
  expect_error(Failure::kUsage, {"Lagrangian", "sand"}, [&] { sand.go(0.1, initial_state(sand.particles)); });
  Motion sleeper(Vec3d::Constant(0.02), 0.01, 1, GridKind::kLagrangian);
  sleeper.options.sleep_speed = 0.01;
  expect_error(Failure::kUsage, {"sleep"}, [&] { sleeper.go(0.1, initial_state(sleeper.particles)); });
  sleeper.options.grid = GridKind::kAutomatic;
  EXPECT_FALSE(is_lagrangian(sleeper.options, sleeper.particles));
}

}  // namespace pliant
