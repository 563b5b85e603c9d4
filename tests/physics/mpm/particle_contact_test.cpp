#include "physics/mpm/particle_contact.h"

#include <gtest/gtest.h>

#include "gaussians/base/random.h"
#include "physics/mpm/contact_list.h"
#include "physics/mpm/mpm.h"
#include "tests/check_adjoint.h"
#include "tests/physics/shapes.h"
#include "tests/physics/simulate/recorded_motion.h"

namespace pliant {
namespace {

constexpr double kStep = 1e-3;

ContactPair<double> pair_of(uint64_t seed, double speed) {
  Random random(5, seed);
  const auto vector = [&](double size) {
    return Vec3d(size * random.uniform(-1, 1), size * random.uniform(-1, 1), size * random.uniform(-1, 1));
  };
  return {{vector(0.3), vector(0.3)},
          {vector(speed), vector(speed)},
          {random.uniform(0.5, 2), random.uniform(0.5, 2)},
          {random.uniform(50, 200), random.uniform(50, 200)},
          1.2};
}
ContactPair<double> exchanged(const ContactPair<double>& p) {
  return {{p.x[1], p.x[0]}, {p.v[1], p.v[0]}, {p.mass[1], p.mass[0]}, {p.stiffness[1], p.stiffness[0]}, p.reach};
}

}  // namespace

// Newton's third law, and a force along the line between the particles but for friction, which is at most the
// coefficient times the push and against the sliding.
TEST(ParticleContact, ForcesAreOppositeAndFrictionIsCoulombs) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const ContactPair<double> p = pair_of(seed, seed % 2 ? 1 : 1e-3);
    const Vec3d J = contact_impulse(p, kStep, 0.4), n = (p.x[0] - p.x[1]).normalized();
    EXPECT_LT((J + contact_impulse(exchanged(p), kStep, 0.4)).norm(), 1e-15);
    const double push = J.dot(n);
    const Vec3d drag = J - push * n, u = p.v[0] - p.v[1];
    EXPECT_GT(push, 0);
    EXPECT_LE(drag.norm(), 0.4 * push * (1 + 1e-12));
    EXPECT_LE(drag.dot(u - u.dot(n) * n), 0);
    EXPECT_LT((contact_impulse(p, kStep, 0.0) - push * n).norm(), 1e-15);
  }
  ContactPair<double> apart = pair_of(1, 1);
  apart.reach = 0.9 * (apart.x[0] - apart.x[1]).norm();
  EXPECT_EQ(contact_impulse(apart, kStep, 0.4), Vec3d::Zero().eval());
}

TEST(ParticleContact, AdjointAgreesWithDifferences) {
  for (const double speed : {1.0, 1e-3})  // slides, sticks
    for (uint64_t seed = 0; seed < 10; ++seed) {
      const ContactPair<double> p = pair_of(seed, speed);
      const auto with = [&](const std::vector<double>& u) {
        ContactPair<double> q = p;
        for (int a = 0; a < 3; ++a) {
          q.x[0][a] = u[a];
          q.v[0][a] = u[3 + a];
        }
        q.mass[0] = u[6];
        q.stiffness[0] = 100 * u[7];
        return q;
      };
      const std::vector<double> at = {p.x[0][0], p.x[0][1], p.x[0][2], p.v[0][0],
                                      p.v[0][1], p.v[0][2], p.mass[0], p.stiffness[0] / 100};
      AdjointCheckOptions options;
      options.step = 1e-7;
      const AdjointCheck result = check_adjoint(
          [&](const std::vector<double>& u) {
            const Vec3d J = contact_impulse(with(u), kStep, 0.4);
            return std::vector<double>{J[0], J[1], J[2]};
          },
          [&](const std::vector<double>& u, const std::vector<double>& adj) {
            ParticleContactGradient<double> by;
            contact_impulse_adjoint(with(u), kStep, 0.4, Vec3d(adj[0], adj[1], adj[2]), by);
            return std::vector<double>{by.x[0], by.x[1], by.x[2], by.v[0],
                                       by.v[1], by.v[2], by.mass, 100 * by.stiffness};
          },
          at, options);
      EXPECT_LT(result.worst, 1e-6) << result.message;
    }
}

// The list holds every pair that is near now and was apart at rest, by comparing all with all.
TEST(ContactList, FindsWhatAComparisonOfAllFinds) {
  BasicParticles<double> p = fixture::block<double>(Vec3d(0.12, 0.02, 0.01), 0.01, 1);
  const size_t one = p.size();
  for (size_t i = 0; i < one; ++i) p.object.push_back(p.position[i].x() > 0.115);
  BasicSimulationState<double> state = initial_state(p);
  for (size_t i = 0; i < one; ++i) {  // wound up, so that turns lie on each other
    const double angle = 150 * p.position[i].x(), r = 0.012 + p.position[i].z();
    state.x[i] = Vec3d(r * std::cos(angle), p.position[i].y(), r * std::sin(angle));
  }
  Mpm<double> solver(p, 0.01, Vec3d::Zero(), {.lagrangian = true});
  solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
  const MpmData<double>& data = solver.data();
  std::vector<Vec3d> x(one);
  for (size_t s = 0; s < one; ++s) x[s] = state.x[data.record[s].index];
  ContactList<double> list;
  EXPECT_TRUE(list.stale());
  list.build(data, x);
  EXPECT_FALSE(list.stale());
  const double reach = (ContactList<double>::kReach + ContactList<double>::kSlack) * 0.01;
  size_t found = 0;
  for (size_t s = 0; s < one; ++s) {
    std::vector<int> near;
    const int i = data.record[s].index;
    for (size_t t = 0; t < one; ++t) {
      const int k = data.record[t].index;
      const bool apart =
          p.object[i] != p.object[k] || (p.position[i] - p.position[k]).norm() >= ContactList<double>::kApart * 0.01;
      if (t != s && apart && (x[s] - x[t]).norm() < reach) near.push_back(static_cast<int>(t));
    }
    EXPECT_TRUE(std::ranges::equal(near, list.near(static_cast<int>(s)))) << s;
    found += near.size();
  }
  EXPECT_GT(found, 1000u);
  const double dt = 0.3 * ContactList<double>::kSlack * 0.01;  // two particles at 1 m/s, against each other
  list.travel(1.0, dt, 0.01);
  EXPECT_FALSE(list.stale());
  list.travel(1.0, dt, 0.01);
  EXPECT_TRUE(list.stale());
}

// Two leaves a little more than four cells apart at rest, in blocks that have no node block in common, so that around
// the node blocks of each there is nothing else.
TEST(ContactList, FindsPartsThatDoNotHangTogetherAlsoWhereNoneIsAroundTheOther) {
  constexpr double dx = 0.01, gap = 4.15 * dx;
  BasicParticles<double> p = fixture::block<double>(Vec3d(0.5, 4, 4) * dx, dx, 0);
  for (Vec3d& x : p.position) x += Vec3d(gap, 0.5 * dx, 0.5 * dx);  // at 4.4 cells along x, the other one at 8.55
  const size_t one = fixture::append_copy(p, Vec3d(gap, 0, 0));
  for (int i = 0; i < static_cast<int>(p.size()); ++i)
    for (int k = 0; k < i; ++k)
      if ((p.position[i] - p.position[k]).norm() < 0.8 * dx) p.links.push_back({k, i});
  BasicSimulationState<double> state = initial_state(p);
  for (size_t i = one; i < p.size(); ++i) state.x[i].x() -= gap - 0.3 * dx;  // laid on the first
  Mpm<double> solver(p, dx, Vec3d::Zero(), {.lagrangian = true});
  solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
  const MpmData<double>& data = solver.data();
  ASSERT_EQ(data.grid.particle_blocks(), 2);
  std::vector<Vec3d> x(p.size());
  for (size_t s = 0; s < p.size(); ++s) x[s] = state.x[data.record[s].index];
  ContactList<double> list;
  list.build(data, x);
  const double reach = (ContactList<double>::kReach + ContactList<double>::kSlack) * dx;
  const auto leaf_of = [&](size_t slot) { return static_cast<size_t>(data.record[slot].index) >= one; };
  for (size_t s = 0; s < p.size(); ++s) {
    ASSERT_EQ(data.grid.part_of(data.record[s].index), 0);
    std::vector<int> near;
    for (size_t t = 0; t < p.size(); ++t)
      if (leaf_of(s) != leaf_of(t) && (x[s] - x[t]).norm() < reach) near.push_back(static_cast<int>(t));
    EXPECT_GT(near.size(), 3u);
    EXPECT_TRUE(std::ranges::equal(near, list.near(static_cast<int>(s)))) << s;
  }
}

}  // namespace pliant
