// Contact between objects: at one node, and as bodies see it.

#include "physics/mpm/object_contact.h"

#include <gtest/gtest.h>

#include "physics/simulate/simulate.h"
#include "tests/check_adjoint.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

using State = BasicSimulationState<double>;
constexpr double kGravity = 9.81;

NodePair random_pair(uint64_t seed, bool approaching) {
  NodePair pair;
  for (int i = 0; i < 2; ++i) {
    Random random(seed, i);
    pair.mass[i] = random.uniform(0.5, 2);
    for (int a = 0; a < 3; ++a) {
      pair.velocity[i][a] = random.normal();
      pair.gradient[i][a] = random.normal();
    }
  }
  const Vec3d n = (pair.gradient[1] - pair.gradient[0]).normalized();
  const double approach = (pair.velocity[0] - pair.velocity[1]).dot(n);
  if ((approach > 0) != approaching) pair.velocity[0] -= 2 * approach * n;
  return pair;
}

std::vector<double> flat(const NodePair& p) {
  std::vector<double> x = {p.mass[0], p.mass[1]};
  for (int i = 0; i < 2; ++i) x.insert(x.end(), p.velocity[i].data(), p.velocity[i].data() + 3);
  for (int i = 0; i < 2; ++i) x.insert(x.end(), p.gradient[i].data(), p.gradient[i].data() + 3);
  return x;
}

NodePair unflat(const std::vector<double>& x) {
  NodePair p;
  p.mass[0] = x[0];
  p.mass[1] = x[1];
  for (int i = 0; i < 2; ++i)
    for (int a = 0; a < 3; ++a) {
      p.velocity[i][a] = x[2 + 3 * i + a];
      p.gradient[i][a] = x[8 + 3 * i + a];
    }
  return p;
}

TEST(ObjectContact, AnExchangeKeepsMomentumLosesEnergyAndLetsGo) {
  for (int s = 0; s < 100; ++s) {
    for (const double mu : {0.0, 0.4, 5.0}) {
      const NodePair before = random_pair(s, true);
      NodePair after = before;
      exchange_impulse(mu, after);
      const auto momentum = [](const NodePair& p) -> Vec3d {
        return p.mass[0] * p.velocity[0] + p.mass[1] * p.velocity[1];
      };
      const auto energy = [](const NodePair& p) {
        return p.mass[0] * p.velocity[0].squaredNorm() + p.mass[1] * p.velocity[1].squaredNorm();
      };
      EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-14);
      EXPECT_LT(energy(after), energy(before));
      const Vec3d n = (before.gradient[1] - before.gradient[0]).normalized();
      EXPECT_NEAR((after.velocity[0] - after.velocity[1]).dot(n), 0, 1e-14);
      // Coulomb: across the normal at most mu times what is along it.
      const Vec3d impulse = before.mass[0] * (before.velocity[0] - after.velocity[0]);
      EXPECT_LE((impulse - impulse.dot(n) * n).norm(), mu * impulse.dot(n) + 1e-14);
      const NodePair parting = random_pair(s, false);
      NodePair left = parting;
      exchange_impulse(mu, left);
      EXPECT_EQ(flat(left), flat(parting));
    }
  }
}

TEST(ObjectContact, TheAdjointAgreesWithDifferences) {
  int sticking = 0, sliding = 0;
  for (int s = 0; s < 12; ++s) {
    const double mu = s % 2 ? 0.2 : 3.0;
    const NodePair pair = random_pair(s + 50, true);
    NodePair after = pair;
    exchange_impulse(mu, after);
    ((after.velocity[0] - after.velocity[1]).norm() < 1e-12 ? sticking : sliding) += 1;
    AdjointCheckOptions options;
    options.step = 1e-3;
    const AdjointCheck check = check_adjoint(
        [&](const std::vector<double>& x) {
          NodePair p = unflat(x);
          exchange_impulse(mu, p);
          const std::vector<double> all = flat(p);
          return std::vector<double>(all.begin() + 2, all.begin() + 8);
        },
        [&](const std::vector<double>& x, const std::vector<double>& adj_y) {
          NodePair adj = unflat(std::vector<double>(14, 0.0));
          for (int i = 0; i < 2; ++i)
            for (int a = 0; a < 3; ++a) adj.velocity[i][a] = adj_y[3 * i + a];
          exchange_impulse_adjoint(mu, unflat(x), adj);
          return flat(adj);
        },
        flat(pair), options);
    EXPECT_LT(check.worst, 1e-6) << s << ": " << check.message;
  }
  EXPECT_GT(sticking, 2);
  EXPECT_GT(sliding, 2);
}

/// Two blocks as objects 0 and 1.
BasicParticles<double> two(BasicParticles<double> a, const BasicParticles<double>& b, const Vec3d& at) {
  a.object.assign(a.size(), 0);
  for (size_t i = 0; i < b.size(); ++i) {
    a.position.push_back(b.position[i] + at);
    a.volume.push_back(b.volume[i]);
    a.mass.push_back(b.mass[i]);
    a.young.push_back(b.young[i]);
    a.poisson.push_back(b.poisson[i]);
    a.object.push_back(1);
  }
  return a;
}

struct Means {
  Vec3d position[2], velocity[2];
  double mass[2];
};
Means means(const BasicParticles<double>& p, const State& s) {
  Means m{{Vec3d::Zero(), Vec3d::Zero()}, {Vec3d::Zero(), Vec3d::Zero()}, {0, 0}};
  for (size_t i = 0; i < s.size(); ++i) {
    const int o = p.object[i];
    m.mass[o] += p.mass[i];
    m.position[o] += p.mass[i] * s.x[i];
    m.velocity[o] += p.mass[i] * s.v[i];
  }
  for (int o = 0; o < 2; ++o) {
    m.position[o] /= m.mass[o];
    m.velocity[o] /= m.mass[o];
  }
  return m;
}

SimulateOptions options_of(double fps, double duration, const Vec3d& gravity = Vec3d::Zero()) {
  SimulateOptions options;
  options.fps = fps;
  options.duration = duration;
  options.gravity = gravity;
  return options;
}

TEST(ObjectContactLaw, EqualBlocksExchangeTheirVelocitiesAndKeepTheirMomentum) {
  const auto bar = fixture::block<double>({0.14, 0.03, 0.03}, 0.01, 1.0, 1e5);
  for (const double gap : {0.013, 0.0178}) {  // cells between them at the start do not matter
    const auto particles = two(bar, bar, Vec3d(0.14 + gap, 0, 0));
    State start = initial_state(particles);
    for (size_t i = 0; i < start.size(); ++i)
      if (particles.object[i] == 0) start.v[i].x() = 0.5;
    double surface = INFINITY;
    const Means before = means(particles, start);
    const Means after =
        means(particles, simulate<double>(options_of(100, 0.12), particles, {}, start, [&](const State& s) {
                           // The gap at which the second block starts to move.
                           const Means now = means(particles, s);
                           if (now.velocity[1].x() > 0.02 && surface == INFINITY)
                             surface = now.position[1].x() - now.position[0].x() - 0.14;
                           return true;
                         }).state);
    const auto total = [](const Means& m) -> Vec3d { return m.mass[0] * m.velocity[0] + m.mass[1] * m.velocity[1]; };
    EXPECT_LT((total(after) - total(before)).norm(), 1e-12 * total(before).norm());
    // Nodes in contact take one velocity, so the outermost cell's share of the energy is lost.
    EXPECT_NEAR(after.velocity[1].x(), 0.5, 0.12 * 0.5);
    EXPECT_NEAR(after.velocity[0].x(), 0.0, 0.12 * 0.5);
    EXPECT_LT(std::abs(surface), 0.006);  // of 1 cell, and 5 mm of way per frame
  }
}

TEST(ObjectContactLaw, BodiesThatPartDoNotStick) {
  const auto bar = fixture::block<double>({0.04, 0.04, 0.04}, 0.01, 1.0, 1e5);
  const auto particles = two(bar, bar, Vec3d(0.04, 0, 0));  // touching
  State start = initial_state(particles);
  for (size_t i = 0; i < start.size(); ++i)
    if (particles.object[i] == 1) start.v[i].x() = 0.3;
  const Means after = means(particles, simulate<double>(options_of(100, 0.1), particles, {}, start).state);
  EXPECT_NEAR(after.velocity[1].x(), 0.3, 1e-12);
  EXPECT_NEAR(after.velocity[0].x(), 0.0, 1e-12);
}

TEST(ObjectContactLaw, ABlockRestsOnAnotherAndSlidesWithSomewhatMoreFriction) {
  const auto slab = fixture::block<double>({0.14, 0.06, 0.03}, 0.01, 1.0, 1e5),
             block = fixture::block<double>({0.05, 0.04, 0.03}, 0.01, 1.0, 1e5);
  const auto particles = two(slab, block, Vec3d(0.01, 0.01, 0.03));
  Interaction pin;
  pin.type = InteractionType::kPin;
  pin.region = Region::half_space(Vec3d(0, 0, 0.012), Vec3d::UnitZ());
  const auto run = [&](GridKind grid, double angle, double friction) {
    SimulateOptions options = options_of(50, 0.3);  // gravity is switched on, for the pin would cancel it
    options.viscosity_time = 6e-4;
    options.object_friction = friction;
    options.grid = grid;
    Interaction gravity;
    gravity.type = InteractionType::kGravity;
    gravity.vector = kGravity * Vec3d(std::sin(angle), 0, -std::cos(angle));
    std::vector<Means> path;
    simulate<double>(options, particles, {pin, gravity}, initial_state(particles),
                     [&](const State& s) { return path.push_back(means(particles, s)), true; });
    return path;
  };
  const double mu = 0.4, critical = std::atan(mu), steep = critical + 0.17;
  // Particles make both surfaces bumpy, which adds to the friction: on an Eulerian grid a little, where particles meet
  // each other more.
  for (const auto& [grid, most] : {std::pair(GridKind::kEulerian, 1.25), std::pair(GridKind::kLagrangian, 1.6)}) {
    const auto rest = run(grid, critical - 0.03, mu), slide = run(grid, steep, mu);
    EXPECT_LT(rest[15].velocity[1].norm(), 0.01);
    EXPECT_NEAR(rest[15].position[1].z() - rest[0].position[1].z(), 0, 0.3 * 0.01);
    const double acceleration = (slide[13].velocity[1] - slide[5].velocity[1]).x() / 0.16;
    const double effective = (std::sin(steep) - acceleration / kGravity) / std::cos(steep);
    EXPECT_GT(effective, mu);
    EXPECT_LT(effective, most * mu);
  }
}

}  // namespace
}  // namespace pliant
