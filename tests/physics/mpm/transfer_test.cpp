// Laws of the transfers between particles and grid, in double on the templates that run in float.

#include <gtest/gtest.h>

#include "physics/mpm/bspline.h"
#include "physics/mpm/mpm.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kEps = 2.220446049250313e-16;

/// A jittered block with random velocities, affine fields and deformations.
struct Cloud {
  BasicParticles<double> particles = fixture::block<double>({0.06, 0.05, 0.07}, 0.01);
  BasicSimulationState<double> state = initial_state(particles);
  Mpm<double> solver{particles, 0.01, Vec3d(0.0031, -0.002, 0.0007)};
  double momentum_scale = 0, angular_scale = 0;

  explicit Cloud(double strain) {
    for (size_t i = 0; i < state.size(); ++i) {
      Random random(3, i);
      for (int a = 0; a < 3; ++a) {
        state.v[i][a] = random.normal();
        for (int b = 0; b < 3; ++b) {
          state.C[i](a, b) = 20 * random.normal();
          state.F[i](a, b) += strain * random.normal();
        }
      }
      momentum_scale += particles.mass[i] * state.v[i].norm();
      angular_scale += particles.mass[i] * state.v[i].norm() * state.x[i].norm();
    }
    solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
  }
};

TEST(Spline, WeightsSumToOneAndReproduceLinearFields) {
  for (int i = 0; i < 10000; ++i) {
    const double x = Random(1, i).uniform(-50, 50);
    const Spline<double> s(x);
    double sum = 0, first = 0, second = 0;
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(s.weight[k], 0);
      sum += s.weight[k];
      first += s.weight[k] * (k - s.offset);
      second += s.weight[k] * (k - s.offset) * (k - s.offset);
    }
    EXPECT_NEAR(sum, 1, 4 * kEps);
    EXPECT_NEAR(first, 0, 4 * kEps);
    EXPECT_NEAR(second, 0.25, 8 * kEps);
    EXPECT_NEAR(s.base + s.offset, x, 64 * kEps);
    EXPECT_TRUE(s.offset >= 0.5 && s.offset < 1.5);
  }
}

TEST(Transfer, TotalMassIsKept) {
  Cloud cloud(0);
  cloud.solver.particles_to_grid(1e-4, {});
  const double n = static_cast<double>(cloud.particles.size()), mass = cloud.particles.total_mass();
  EXPECT_NEAR(cloud.solver.grid_totals(false).mass / mass, 1, 1e-14 * std::sqrt(n));
}

TEST(Transfer, ScatterKeepsLinearAndAngularMomentumUnderStress) {
  for (const double strain : {0.0, 0.1, 0.6}) {
    Cloud cloud(strain);
    const Totals before = cloud.solver.particle_totals();
    cloud.solver.particles_to_grid(1e-4, {});
    const Totals after = cloud.solver.grid_totals(false);
    // Internal forces add impulses that cancel; their size is part of the scale.
    double impulse = 0;
    for (size_t i = 0; i < cloud.particles.size(); ++i)
      impulse += 1e-4 * cloud.particles.volume[i] * 1e4 * strain * (1 + strain) * (1 + strain) * 4 / 0.01 * 3;
    const double scale = cloud.momentum_scale + impulse;
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * scale) << strain;
    EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * (cloud.angular_scale + 0.1 * impulse)) << strain;
  }
}

TEST(Transfer, GatherKeepsLinearAndAngularMomentum) {
  Cloud cloud(0.1);
  const StepLoads<double> none;
  const double dt = 1e-4;
  cloud.solver.particles_to_grid(dt, none);
  cloud.solver.update_grid(dt, none);
  const Totals grid = cloud.solver.grid_totals(true);
  cloud.solver.grid_to_particles(dt);
  // x moves along v in this step, so x cross v is that of the old positions.
  const Totals after = cloud.solver.particle_totals();
  EXPECT_LT((after.momentum - grid.momentum).norm(), 1e-12 * cloud.momentum_scale);
  EXPECT_LT((after.angular - grid.angular).norm(), 1e-12 * cloud.angular_scale);
}

TEST(Transfer, AffineVelocityFieldsAreReproduced) {
  Cloud cloud(0);
  Mat3d A;
  A << 1, -2, 3, 0.5, 4, -1, 2, 1, -3;
  const Vec3d b(0.3, -0.2, 0.1);
  for (size_t i = 0; i < cloud.state.size(); ++i) {
    cloud.state.v[i] = A * cloud.state.x[i] + b;
    cloud.state.C[i] = A;
    cloud.state.F[i].setIdentity();
  }
  cloud.solver.load(cloud.state, Vec3d::Constant(-1), Vec3d::Constant(1));
  const double dt = 1e-6;
  cloud.solver.particles_to_grid(dt, {});
  cloud.solver.update_grid(dt, {});
  cloud.solver.grid_to_particles(dt);
  BasicSimulationState<double> after;
  cloud.solver.store(after);
  for (size_t i = 0; i < after.size(); ++i) {
    ASSERT_LT((after.v[i] - cloud.state.v[i]).norm(), 1e-13);
    ASSERT_LT((after.C[i] - A).norm(), 1e-11);
    ASSERT_LT((after.F[i] - (Mat3d::Identity() + dt * A)).norm(), 1e-15);
    ASSERT_LT((after.x[i] - (cloud.state.x[i] + dt * cloud.state.v[i])).norm(), 1e-16);
  }
}

TEST(Transfer, DampingScalesTheMomentumByItsFactor) {
  Cloud cloud(0);
  StepLoads<double> loads;
  loads.velocity_scale = 0.75;
  cloud.solver.particles_to_grid(1e-4, loads);
  const Totals before = cloud.solver.grid_totals(false);
  cloud.solver.update_grid(1e-4, loads);
  EXPECT_LT((cloud.solver.grid_totals(true).momentum - 0.75 * before.momentum).norm(), 1e-12 * cloud.momentum_scale);
}

}  // namespace
}  // namespace pliant
