// Gradients of roll-outs on a Lagrangian grid against differences, in double.

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/base/check_adjoint.h"
#include "tests/physics/simulate/adjoint_rollout_case.h"

namespace pliant {
namespace {

using testing::Input;
using Case = testing::RolloutCase<double>;

Case lagrangian_block(double cells = 2.5) {
  Case c = testing::moving_block<double>(cells);
  c.options.simulate.grid = GridKind::kLagrangian;
  return c;
}

void expect_gradient(const Case& c) {
  const RolloutGradient<double> gradient = c.gradient();
  for (const auto& [kind, name] : testing::kInputs) {
    const bool off = kind == Input::kDamping && !(c.options.simulate.viscosity_time > 0);  // at the end of its range
    if (off || c.get(kind).empty()) continue;
    AdjointCheckOptions options;
    options.step = 1e-5;
    options.random_cotangents = 0;
    options.inputs = 4;
    options.random_directions = 1;
    const AdjointCheck result =
        check_adjoint([&](const std::vector<double>& u) { return std::vector<double>{c.with(kind, u).value()}; },
                      [&](const std::vector<double>&, const std::vector<double>& adj) {
                        std::vector<double> g = c.part(gradient, kind);
                        for (double& x : g) x *= adj[0];
                        return g;
                      },
                      c.get(kind), options);
    EXPECT_LT(result.worst, 1e-5) << name << ": " << result.message;
  }
}

Case without_viscosity(Case c) {
  c.options.simulate.viscosity_time = 0;
  c.particles.materials.back().viscosity_time = c.particles.materials.back().damping_time = 0;
  return c;
}

}  // namespace

TEST(LagrangianAdjoint, SixtySubstepsOnAPinAgreeWithDifferences) {
  Case c = lagrangian_block();
  c.interactions.push_back(testing::pin_below(0.004));
  c.interactions.back().duration = 0.01;  // then it falls
  expect_gradient(c);
}

TEST(LagrangianAdjoint, OfOneLawWithoutViscosityAgreeWithDifferences) {
  for (const bool rubber : {false, true}) {
    Case c = without_viscosity(lagrangian_block(2));
    c.particles.material_index.assign(c.particles.size(), rubber);
    expect_gradient(c);
  }
}

TEST(LagrangianAdjoint, SixtySubstepsOnTheGroundWithFrictionAgreeWithDifferences) {
  Case c = lagrangian_block();
  c.interactions.push_back(testing::ground(0, 0.3));
  for (auto& v : c.start.v) v += Vec3d(0.5, 0.2, -0.6);
  Case free = c;
  free.interactions.pop_back();
  ASSERT_GT((rollout(c.options, c.particles, c.interactions, c.start).frames.back().x[0] -
             rollout(free.options, free.particles, free.interactions, free.start).frames.back().x[0])
                .norm(),
            1e-3);
  expect_gradient(c);
}

TEST(LagrangianAdjoint, EqualBitForBitForAnyNumberOfThreadsAndForRecomputedSubsteps) {
  Case c = lagrangian_block(8);
  c.options.simulate.duration = 0.01;
  c.interactions.push_back(testing::ground(0, 0.3));
  const RolloutGradient<double> whole = c.gradient();
  const int threads = omp_get_max_threads();
  const auto expect_equal = [&](const RolloutGradient<double>& g, const char* how) {
    EXPECT_TRUE(g.start.x == whole.start.x && g.start.v == whole.start.v && g.start.C == whole.start.C &&
                g.start.F == whole.start.F && g.young == whole.young && g.mass == whole.mass)
        << how;
  };
  for (const int n : {1, 2, 4}) {
    omp_set_num_threads(n);
    expect_equal(c.gradient(), "threads");
  }
  omp_set_num_threads(threads);
  c.options.memory = 1;
  expect_equal(c.gradient(), "recomputed");
}

}  // namespace pliant
