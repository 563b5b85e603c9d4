// Parts of elastic bodies that meet push each other apart.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/simulate/energy.h"
#include "physics/simulate/simulator.h"
#include "tests/physics/simulate/recorded_motion.h"

namespace pliant {
namespace {

using fixture::Motion;
using fixture::pin_left;
using State = Motion::State;
constexpr double kCell = 0.01;

/// Two blocks of four cells, one cell and a half apart along x, as two bodies.
struct TwoBlocks : Motion {
  size_t one;

  explicit TwoBlocks(double gap = 1.5) : Motion(Vec3d::Constant(4 * kCell), kCell, 0.5, GridKind::kLagrangian) {
    one = fixture::append_copy(particles, Vec3d((4 + gap) * kCell, 0, 0));
    for (size_t i = 0; i < particles.size(); ++i) particles.object.push_back(i >= one);
  }
  Vec3d mean(const std::vector<Vec3d>& values, size_t from, size_t to) const {
    Vec3d sum = Vec3d::Zero();
    for (size_t i = from; i < to; ++i) sum += values[i];
    return sum / static_cast<double>(to - from);
  }
};

}  // namespace

// Two leaves three tenths of a cell apart, of which one is pushed down by three cells: it takes the other along, and
// nowhere do they change sides.
TEST(SelfContact, LeavesThatArePushedTogetherDoNotPassThroughEachOther) {
  fixture::TwoLeaves leaves;
  leaves.link();
  leaves.move_upper(-3);
  const BasicParticles<double>& p = leaves.particles;
  const size_t one = leaves.one;
  double pushed = 0, nearest = INFINITY;
  for (const State& s : leaves.states)
    for (size_t i = 0; i < one; ++i) {
      pushed = std::max(pushed, (p.position[i] - s.x[i]).z() / kCell);
      // Along the normal of the lower leaf, F^-T e_z.
      const Vec3d normal = cofactor(s.F[i]).col(2).normalized();
      nearest = std::min(nearest, (s.x[one + i] - s.x[i]).dot(normal) / kCell);
    }
  EXPECT_GT(pushed, 2.0);
  EXPECT_GT(nearest, 0.25) << "cells between particles that lie above each other, 0.8 at rest";
  RecordProperty("largest_penetration_cells", std::to_string(0.8 - nearest));
}

// Without friction contact forces have a potential: what collides keeps momentum exactly and energy up to the step.
TEST(SelfContact, ACollisionKeepsMomentumAndEnergy) {
  TwoBlocks blocks;
  blocks.options.object_friction = 0;
  blocks.options.fps = 2000;
  State start = initial_state(blocks.particles);
  for (size_t i = 0; i < blocks.one; ++i) start.v[i].x() = 1.0;
  SimulateSummary summary;
  Simulator<double> simulator(blocks.options, blocks.particles, {}, summary);
  const auto totals = [&] { return simulator.solver().grid_totals(true); };
  const auto energy = [&](const State& s) {
    const auto nodes = simulator.solver().node_energy();
    return nodes.kinetic + nodes.stabilization + elastic_energy(blocks.particles, s);
  };
  State state = start;
  simulator.advance(state);
  const Totals before = totals();
  const double first = energy(state);
  double least = first;
  while (state.time < 0.06) {
    simulator.advance(state);
    least = std::min(least, energy(state));
  }
  const Totals after = totals();
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
  EXPECT_LT((after.angular - before.angular).norm(), 1e-10 * before.angular.norm());
  EXPECT_LT(least, 0.97 * first) << "some of it is in the contact for a while";
  EXPECT_NEAR(energy(state) / first, 1, 2e-3);
  const Vec3d v[2] = {blocks.mean(state.v, 0, blocks.one), blocks.mean(state.v, blocks.one, state.size())};
  EXPECT_GT(v[1].x() - v[0].x(), 0.5) << "they part again";
}

// However far apart they begin and however long a frame is: a list of near particles that holds too long would find
// them deep in each other, and add energy or let them pass.
TEST(SelfContact, ACollisionWithinAFrameKeepsEnergyFromAnyDistance) {
  for (const double gap : {0.7, 0.85, 1.0, 1.15, 1.3, 1.5}) {
    TwoBlocks blocks(gap);
    blocks.options.object_friction = 0;
    blocks.options.fps = 30;
    State state = initial_state(blocks.particles);
    for (size_t i = 0; i < blocks.one; ++i) state.v[i].x() = 1.0;
    double before = 0;
    for (size_t i = 0; i < blocks.one; ++i) before += 0.5 * blocks.particles.mass[i];
    SimulateSummary summary;
    Simulator<double> simulator(blocks.options, blocks.particles, {}, summary);
    while (state.time < 0.09) simulator.advance(state);
    const auto nodes = simulator.solver().node_energy();
    const double after = nodes.kinetic + nodes.stabilization + elastic_energy(blocks.particles, state);
    EXPECT_NEAR(after / before, 1, 2e-2) << gap;
    EXPECT_EQ(summary.retries, 0) << gap;
    const Vec3d v[2] = {blocks.mean(state.v, 0, blocks.one), blocks.mean(state.v, blocks.one, state.size())};
    EXPECT_GT(v[1].x() - v[0].x(), 0.5) << gap << ": they part again";
  }
}

// Two bodies at 1 and 0 m/s move at 0.5 m/s against their mean; one of them that turns is measured at its corners.
TEST(SelfContact, SpeedsOfALagrangianRunAreThoseOfTheParticlesFromTheirMean) {
  for (const double spin : {0.0, 10.0}) {  // rad/s
    TwoBlocks blocks(6);
    blocks.options.fps = 2000;
    State state = initial_state(blocks.particles);
    const Vec3d middle = Vec3d::Constant(2 * kCell), omega(0, 0, spin);
    Mat3d rate;
    rate << 0, -spin, 0, spin, 0, 0, 0, 0, 0;
    for (size_t i = 0; i < blocks.one; ++i) {
      state.v[i] = Vec3d(1, 0, 0) + omega.cross(state.x[i] - middle);
      state.C[i] = rate;
    }
    SimulateSummary summary;
    Simulator<double> simulator(blocks.options, blocks.particles, {}, summary);
    simulator.advance(state);
    const Vec3d mean = blocks.mean(state.v, 0, state.size());
    double fastest = 0;
    for (const Vec3d& v : state.v) fastest = std::max(fastest, (v - mean).norm());
    EXPECT_GE(simulator.solver().max_speed(), (1 - 1e-6) * fastest) << spin;
    EXPECT_LE(simulator.solver().max_speed(), (spin > 0 ? 1.5 : 1 + 1e-6) * fastest) << spin;
  }
}

// A block that slides on a floor of the same kind under its weight is slowed by friction times g.
TEST(SelfContact, FrictionBetweenBodiesIsCoulombs) {
  const Vec3d size(6 * kCell, 4 * kCell, 3 * kCell);
  Motion sliding(size, kCell, 0, GridKind::kLagrangian);
  BasicParticles<double>& p = sliding.particles;
  const size_t one = p.size();
  // The floor, which the ground holds.
  const BasicParticles<double> floor = fixture::block<double>(Vec3d(24 * kCell, 8 * kCell, 3 * kCell), kCell, 0, 1e5);
  for (size_t i = 0; i < floor.size(); ++i) {
    p.position.push_back(floor.position[i] - Vec3d(2 * kCell, 2 * kCell, 3.2 * kCell));
    p.volume.push_back(floor.volume[i]);
    p.mass.push_back(floor.mass[i]);
    p.young.push_back(floor.young[i]);
    p.poisson.push_back(floor.poisson[i]);
  }
  for (size_t i = 0; i < p.size(); ++i) p.object.push_back(i >= one);
  sliding.options.gravity = Vec3d(0, 0, -9.81);
  sliding.options.object_friction = 0.3;
  Interaction ground;
  ground.type = InteractionType::kGround;
  ground.region = Region::half_space(Vec3d(0, 0, -3.2 * kCell), Vec3d(0, 0, 1));
  ground.friction = INFINITY;
  sliding.script = {ground};
  State start = initial_state(p);
  for (size_t i = 0; i < one; ++i) start.v[i].x() = 0.5;
  sliding.go(0.1, start);
  const auto speed = [&](const State& s) {
    double sum = 0;
    for (size_t i = 0; i < one; ++i) sum += s.v[i].x() / static_cast<double>(one);
    return sum;
  };
  const double slowed = speed(sliding.states.front()) - speed(sliding.states.back());
  EXPECT_NEAR(slowed, 0.3 * 9.81 * 0.1, 0.1 * 0.3 * 9.81 * 0.1);
}

}  // namespace pliant
