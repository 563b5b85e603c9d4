// Gradients of roll-outs on a Lagrangian grid against differences, in double; adjoint_rollout_test has more, of both
// grids.

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>

#include "tests/check_adjoint.h"
#include "tests/physics/simulate/adjoint_rollout_case.h"

namespace pliant {
namespace {

using fixture::Input;
using Case = fixture::RolloutCase<double>;

Case lagrangian_block(double cells = 2.5) {
  Case c = fixture::moving_block<double>(cells);
  c.options.simulate.grid = GridKind::kLagrangian;
  return c;
}

void expect_lagrangian_gradient(const Case& c) {
  const RolloutGradient<double> gradient = c.gradient();
  const bool collider = std::any_of(c.interactions.begin(), c.interactions.end(), [](const Interaction& it) {
    return it.type == InteractionType::kCollider;  // `vector` is its velocity, by which there is no derivative
  });
  for (const auto& [kind, name] : fixture::kInputs) {
    const bool off =
        (kind == Input::kDamping && !(c.options.simulate.viscosity_time > 0)) ||  // at the end of its range
        (kind == Input::kForces && collider);
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

/// Two blocks of two cells that are pushed into each other; at rest the second one begins `begin` cells from where the
/// first one does.
Case meeting_blocks(double begin) {
  Case c = lagrangian_block(2);
  const size_t one = c.particles.size();
  const double dx = c.particles.cell_size;
  const auto append = [&](auto& values) { values.insert(values.end(), values.begin(), values.begin() + one); };
  append(c.particles.position);
  for (auto* values : {&c.particles.volume, &c.particles.mass, &c.particles.young, &c.particles.poisson})
    append(*values);
  append(c.particles.material_index);
  append(c.start.x);
  append(c.start.v);
  append(c.start.C);
  append(c.start.F);
  const Vec3d shift(begin * dx, 0.2 * dx, 0.1 * dx);
  for (size_t i = one; i < 2 * one; ++i) {
    c.particles.position[i] += shift;
    c.start.x[i] += Vec3d(2.3 * dx, 0.2 * dx, 0.1 * dx);
    c.start.v[i] += Vec3d(-1, 0.3, 0);
  }
  return c;
}

BasicSimulationState<double> end_of(const Case& c) {
  return rollout(c.options, c.particles, c.interactions, c.start).frames.back();
}

void expect_gradient_in_contact(Case c) {
  c.options.simulate.object_friction = 0;
  const Vec3d smooth = end_of(c).x[0];
  c.options.simulate.object_friction = 0.3;
  ASSERT_GT((end_of(c).x[0] - smooth).norm(), 1e-6) << "they touch";
  expect_lagrangian_gradient(c);
}

}  // namespace

TEST(LagrangianAdjoint, OfOneLawWithoutViscosityAgreeWithDifferences) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky}) {
    Case c = without_viscosity(lagrangian_block(2));
    c.particles.materials.back().law = law;
    c.particles.material_index.assign(c.particles.size(), 1);
    expect_lagrangian_gradient(c);
  }
}

TEST(LagrangianAdjoint, OfThreeLawsWithViscositySideBySideAgreeWithDifferences) {
  Case c = lagrangian_block(2);
  c.particles.materials.insert(c.particles.materials.begin() + 1, Material{.law = Law::kHencky});
  for (size_t i = 0; i < c.particles.size(); ++i) c.particles.material_index[i] = i % 3;
  expect_lagrangian_gradient(c);
}

TEST(LagrangianAdjoint, SixtySubstepsInContactAgreeWithDifferences) {
  Case c = meeting_blocks(3);
  for (size_t i = 0; i < c.particles.size(); ++i) c.particles.object.push_back(2 * i >= c.particles.size());
  expect_gradient_in_contact(c);
}

// Parts of one body, 0.3 cells apart, that no link joins: they have nodes of their own at the same places.
TEST(LagrangianAdjoint, OfLinkedPartsInContactAgreeWithDifferences) {
  Case c = meeting_blocks(2.3);
  const int n = static_cast<int>(c.particles.size());
  const Vec3d common = end_of(c).x[0];
  for (int i = 0; i < n; ++i)
    for (int k = i + 1; k < n; ++k)
      if ((2 * i >= n) == (2 * k >= n) &&
          (c.particles.position[i] - c.particles.position[k]).norm() < c.particles.cell_size)
        c.particles.links.push_back({i, k});
  ASSERT_GT((end_of(c).x[0] - common).norm(), 1e-4) << "without links they share nodes";
  expect_gradient_in_contact(c);
}

// Nodes move along the surfaces, with which normals and the velocity of what turns change.
TEST(LagrangianAdjoint, OnCurvedAndTurningCollidersAgreeWithDifferences) {
  for (const bool turns : {false, true}) {
    Case c = lagrangian_block(2);
    Interaction obstacle;
    obstacle.type = InteractionType::kCollider;
    obstacle.friction = 0.3;
    obstacle.region = Region::sphere(Vec3d(0.008, 0.011, -0.03), 0.03);
    if (turns) {
      obstacle.contact = ContactKind::kSlip;
      obstacle.region = Region::cylinder(Vec3d(-0.1, 0.011, -0.03), Vec3d(0.1, 0.011, -0.03), 0.03);
      obstacle.angular_velocity = Vec3d(-20, 3, 5);
      obstacle.pivot = Vec3d(0, 0.011, -0.03);
    }
    for (Vec3d& v : c.start.v) v += Vec3d(0.5, 0.2, -0.6);
    const Vec3d free = end_of(c).x[0];
    c.interactions.push_back(obstacle);
    ASSERT_GT((end_of(c).x[0] - free).norm(), 1e-4) << "they touch";
    expect_lagrangian_gradient(c);
  }
}

TEST(LagrangianAdjoint, EqualBitForBitForAnyNumberOfThreadsAndForRecomputedSubsteps) {
  Case c = lagrangian_block(8);
  c.options.simulate.duration = 0.01;
  c.interactions.push_back(fixture::ground(0, 0.3));
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
