// Kernels of both instruction sets in float against plain loops in double, and bits that do not depend on threads.

#include <gtest/gtest.h>
#include <omp.h>

#include <Eigen/LU>
#include <array>
#include <cstdlib>
#include <map>

#include "physics/mpm/bspline.h"
#include "physics/mpm/kernels/kernels.h"
#include "physics/mpm/mpm.h"
#include "tests/instruction_sets.h"
#include "tests/physics/shapes.h"

namespace pliant {
namespace {

constexpr double kMu = 3e4, kLambda = 5e4;

Mat3d random_matrix(uint64_t element, double spread) {
  Random random(11, element);
  Mat3d F;
  for (int k = 0; k < 9; ++k) F(k / 3, k % 3) = (k % 4 == 0) + spread * random.normal();
  return F;
}

Mat3d law_stress(const Material& material, double mu, double lambda, const Mat3d& F) {
  return kirchhoff_stress<double>({&material, mu, lambda}, F, {});
}

template <class T>
void call_law(StressKind kind, const T* F, T mu, T lambda, T* tau) {
  const Material material{.law = kind == StressKind::kNeoHookean ? Law::kNeoHookean : Law::kFixedCorotated};
  const Mat3<T> matrix = Eigen::Map<const Eigen::Matrix<T, 3, 3, Eigen::RowMajor>>(F);
  const Mat3<T> stress = kirchhoff_stress<T>({&material, mu, lambda}, matrix, {});
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int k = 0; k < 6; ++k) tau[k] = stress(row[k], column[k]);
}

template <class T>
void expect_stress_of_law(InstructionSet set, Law law, double spread, double tolerance) {
  const int n = 203;
  std::vector<T> F(9 * n), mu(n), lambda(n), tau(6 * n);
  std::vector<Mat3d> matrix(n);
  for (int i = 0; i < n; ++i) {
    matrix[i] = random_matrix(i, spread);
    for (int k = 0; k < 9; ++k) F[9 * i + k] = static_cast<T>(matrix[i](k / 3, k % 3));
    mu[i] = static_cast<T>(kMu * (1 + i % 4));
    lambda[i] = static_cast<T>(kLambda * (1 + i % 4));
  }
  const StressKind kind = law == Law::kNeoHookean ? StressKind::kNeoHookean : StressKind::kFixedCorotated;
  mpm_kernels<T>(set).stress(kind, n, F.data(), mu.data(), lambda.data(), call_law<T>, tau.data());
  const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  for (int i = 0; i < n; ++i) {
    const Mat3d expected = law_stress({.law = law}, mu[i], lambda[i], matrix[i]);
    const double scale =
        tolerance * std::max((mu[i] + lambda[i]) * (1 + std::pow(matrix[i].norm(), 6)), expected.norm());
    for (int k = 0; k < 6; ++k)
      ASSERT_NEAR(tau[6 * i + k], expected(row[k], column[k]), scale)
          << law_name(law) << " " << name_of(set) << " det " << matrix[i].determinant();
  }
}

TEST(StressKernels, EqualTheLawNearRest) {
  for (const InstructionSet set : fixture::instruction_sets())
    for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean}) {
      expect_stress_of_law<double>(set, law, 0.1, 1e-14);
      expect_stress_of_law<float>(set, law, 0.1, 2e-6);
    }
}

TEST(StressKernels, SurviveInvertedAndStretchedMatrices) {
  for (const InstructionSet set : fixture::instruction_sets())
    for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean}) {
      expect_stress_of_law<double>(set, law, 1.0, 1e-13);
      expect_stress_of_law<float>(set, law, 1.0, 1e-5);
    }
}

TEST(StressKernels, ExtremeMatricesGetTheStressOfTheLawItself) {
  std::vector<Mat3<float>> extreme = {
      Mat3<float>::Zero(),      1e-8f * Mat3<float>::Identity(),   1e8f * Mat3<float>::Identity(),
      -Mat3<float>::Identity(), Vec3<float>(1, 1, 0).asDiagonal(), Vec3<float>(3, 1, -0.5f).asDiagonal()};
  for (const InstructionSet set : fixture::instruction_sets())
    for (const StressKind kind : {StressKind::kFixedCorotated, StressKind::kNeoHookean})
      for (const Mat3<float>& F : extreme) {
        // Beside a healthy particle in the same pack.
        float in[18], mu[2] = {kMu, kMu}, lambda[2] = {kLambda, kLambda}, tau[12], expected[6];
        for (int k = 0; k < 9; ++k) {
          in[k] = F(k / 3, k % 3);
          in[9 + k] = static_cast<float>(k % 4 == 0);
        }
        mpm_kernels<float>(set).stress(kind, 2, in, mu, lambda, call_law<float>, tau);
        call_law<float>(kind, in, mu[0], lambda[0], expected);
        for (int k = 0; k < 6; ++k) {
          EXPECT_EQ(tau[k], expected[k]) << F;
          EXPECT_NEAR(tau[6 + k], 0, 1e-6 * kMu);
        }
      }
}

/// A jittered block in motion, with what a plain implementation in double makes of it in one step.
struct OneStep {
  static constexpr double kDx = 0.01, kDt = 1e-4;
  BasicParticles<float> particles = fixture::block<float>({0.11, 0.05, 0.07}, kDx, 1.0, 1e5);
  BasicSimulationState<float> state = initial_state(particles);
  StepLoads<float> loads;
  Vec3d origin{0.0031, -0.002, 0.0007};

  OneStep() {
    for (size_t i = 0; i < state.size(); ++i) {
      Random random(3, i);
      for (int a = 0; a < 3; ++a) {
        state.v[i][a] = static_cast<float>(random.normal());
        for (int b = 0; b < 3; ++b) {
          state.C[i](a, b) = static_cast<float>(20 * random.normal());
          state.F[i](a, b) += static_cast<float>(0.1 * random.normal());
        }
      }
    }
    loads.gravity = Vec3<float>(1, 2, -9.81f);
    loads.velocity_scale = 0.99f;
  }

  BasicSimulationState<float> by_solver() const {
    Mpm<float> solver(particles, kDx, origin);
    solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
    StepLoads<float> same = loads;
    EXPECT_TRUE(solver.advance(
        1, static_cast<float>(kDt), same, [](int) {}, [] { return true; }));
    BasicSimulationState<float> after;
    solver.store(after);
    return after;
  }

  struct PlainNode {
    Vec3d v = Vec3d::Zero();  // momentum, then velocity
    double mass = 0;
  };
  BasicSimulationState<double> by_loops() const {
    std::map<std::array<int, 3>, PlainNode> node;
    const auto splines = [&](size_t i) {
      const Vec3d g = (state.x[i].cast<double>() - origin.cast<float>().cast<double>()) / kDx;
      return std::array<Spline<double>, 3>{Spline<double>(g.x()), Spline<double>(g.y()), Spline<double>(g.z())};
    };
    const auto for_nodes = [&](size_t i, auto&& visit) {
      const auto s = splines(i);
      for (int k = 0; k < 27; ++k) {
        const int at[3] = {k / 9, k / 3 % 3, k % 3};
        Vec3d d;
        for (int a = 0; a < 3; ++a) d[a] = kDx * (at[a] - s[a].offset);
        visit(node[{s[0].base + at[0], s[1].base + at[1], s[2].base + at[2]}],
              s[0].weight[at[0]] * s[1].weight[at[1]] * s[2].weight[at[2]], d);
      }
    };
    for (size_t i = 0; i < state.size(); ++i) {
      const Material& material = particles.material(i);
      const Lame<double> lame_of = lame<double>(particles.young[i], particles.poisson[i]);
      const Mat3d C = state.C[i].cast<double>(), D = 0.5 * (C + C.transpose());
      const Viscosity<double> viscous = viscosity<double>({&material, lame_of.mu, lame_of.lambda});
      const double time = loads.viscosity_time, mass = particles.mass[i];
      const Mat3d tau = law_stress(material, lame_of.mu, lame_of.lambda, state.F[i].cast<double>()) +
                        2 * (time * lame_of.mu + viscous.shear) * D +
                        (time * lame_of.lambda + viscous.bulk) * D.trace() * Mat3d::Identity();
      const double kept = material.damping_time > 0 ? std::exp(-2 * kDt / material.damping_time) : 1.0;
      for_nodes(i, [&](PlainNode& n, double w, const Vec3d& d) {
        n.v += w * (mass * kept * (state.v[i].cast<double>() + C * d) -
                    kDt * particles.volume[i] * 4 / (kDx * kDx) * (tau * d));
        n.mass += w * mass;
      });
    }
    for (auto& [at, n] : node) n.v = loads.velocity_scale * (n.v / n.mass + kDt * loads.gravity.cast<double>()).eval();
    BasicSimulationState<double> after;
    for (size_t i = 0; i < state.size(); ++i) {
      Vec3d v = Vec3d::Zero();
      Mat3d C = Mat3d::Zero();
      for_nodes(i, [&](PlainNode& n, double w, const Vec3d& d) {
        v += w * n.v;
        C += w * 4 / (kDx * kDx) * n.v * d.transpose();
      });
      after.x.push_back(state.x[i].cast<double>() + kDt * v);
      after.v.push_back(v);
      after.C.push_back(C);
      const Mat3d step = Mat3d::Identity() + kDt * C;
      after.F.push_back(step * state.F[i].cast<double>());
      after.memory.emplace_back();
      after.memory.back().F_total = step;
      const Lame<double> lame_of = lame<double>(particles.young[i], particles.poisson[i]);
      return_map<double>({&particles.material(i), lame_of.mu, lame_of.lambda}, kDt, after.F[i], after.memory[i]);
    }
    return after;
  }

  void expect_equal() const {
    const BasicSimulationState<double> expected = by_loops();
    for (const InstructionSet set : fixture::instruction_sets()) {
      setenv("PLIANT_INSTRUCTION_SET", name_of(set), 1);
      const BasicSimulationState<float> got = by_solver();
      unsetenv("PLIANT_INSTRUCTION_SET");
      for (size_t i = 0; i < got.size(); ++i) {
        ASSERT_LT((got.x[i].cast<double>() - expected.x[i]).norm(), 2e-8) << name_of(set) << " " << i;
        ASSERT_LT((got.v[i].cast<double>() - expected.v[i]).norm(), 2e-5) << name_of(set) << " " << i;
        ASSERT_LT((got.C[i].cast<double>() - expected.C[i]).norm(), 8e-5 / kDx) << name_of(set) << " " << i;
        ASSERT_LT((got.F[i].cast<double>() - expected.F[i]).norm(), 2e-6) << name_of(set) << " " << i;
        if (!has_memory(particles.material(i).law)) continue;
        ASSERT_LT((got.memory[i].F_total.cast<double>() - expected.memory[i].F_total).norm(), 1e-6);
        ASSERT_NEAR(got.memory[i].history, expected.memory[i].history, 1e-6);
      }
    }
  }
};

TEST(MpmKernels, OneStepEqualsPlainLoopsInDouble) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky}) {
    OneStep step;
    step.particles.materials[0].law = law;
    step.expect_equal();
  }
}

TEST(MpmKernels, MixedLawsViscosityAndDampingEqualPlainLoopsInDouble) {
  OneStep step;
  step.particles.materials = {{.law = Law::kFixedCorotated, .viscosity_time = 1e-4},
                              {.law = Law::kNeoHookean, .damping_time = 2e-3},
                              {.law = Law::kHencky},
                              {.law = Law::kMetal, .yield_stress = 1e4, .hardening = 1e4}};
  for (size_t i = 0; i < step.particles.size(); ++i)
    step.particles.material_index.push_back(static_cast<uint16_t>(Random(8, i).uniform(0, 4)));
  step.loads.viscosity_time = 5e-5f;
  step.expect_equal();
}

TEST(MpmKernels, BitsDoNotDependOnTheNumberOfThreads) {
  BasicParticles<float> particles = fixture::block<float>({0.16, 0.08, 0.08}, 0.01, 1.0, 1e5);
  particles.materials = {
      {.law = Law::kFixedCorotated},
      {.law = Law::kNeoHookean},
      {.law = Law::kViscoelastic, .branch_shear = 1e4, .branch_lambda = 1e4, .branch_viscosity = 100}};
  BasicSimulationState<float> state = initial_state(particles), first;
  for (size_t i = 0; i < particles.size(); ++i) {
    particles.material_index.push_back(static_cast<uint16_t>(Random(8, i).uniform(0, 3)));
    state.v[i] = Vec3<float>(-10 * state.x[i].y(), 10 * state.x[i].x(), 5 * state.x[i].y());
  }
  const int most = omp_get_max_threads();
  for (int threads = 1; threads <= 4; ++threads) {
    omp_set_num_threads(threads);
    Mpm<float> solver(particles, 0.01, Vec3d::Zero());
    solver.load(state, Vec3d::Constant(-1), Vec3d::Constant(1));
    StepLoads<float> loads;
    loads.gravity = Vec3<float>(0, 0, -9.81f);
    ASSERT_TRUE(solver.advance(
        40, 3e-4f, loads, [](int) {}, [] { return true; }));
    BasicSimulationState<float> after;
    solver.store(after);
    if (threads == 1) first = after;
    ASSERT_EQ(after.x, first.x) << threads;
    ASSERT_EQ(after.v, first.v) << threads;
    ASSERT_EQ(after.C, first.C) << threads;
    ASSERT_EQ(after.F, first.F) << threads;
  }
  omp_set_num_threads(most);
}

TEST(MpmKernels, AFreeBodyKeepsMassMomentumAndAngularMomentum) {
  const BasicParticles<float> particles = fixture::block<float>({0.08, 0.06, 0.06}, 0.01, 1.0, 1e4);
  BasicSimulationState<float> state = initial_state(particles);
  for (size_t i = 0; i < particles.size(); ++i)
    state.v[i] = Vec3<float>(0.3f - 10 * state.x[i].y(), 10 * state.x[i].x(), 0.1f);
  for (const InstructionSet set : fixture::instruction_sets()) {
    setenv("PLIANT_INSTRUCTION_SET", name_of(set), 1);
    Mpm<float> solver(particles, 0.01, Vec3d::Zero());
    unsetenv("PLIANT_INSTRUCTION_SET");
    solver.load(state, Vec3d::Constant(-10), Vec3d::Constant(10));
    const Totals before = solver.particle_totals();
    StepLoads<float> none;
    ASSERT_TRUE(solver.advance(
        500, 5e-4f, none, [](int) {}, [] { return true; }));
    const Totals after = solver.particle_totals();
    EXPECT_EQ(after.mass, before.mass);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-4 * before.momentum.norm());
    EXPECT_LT((after.angular - before.angular).norm(), 1e-4 * before.angular.norm());
  }
}

}  // namespace
}  // namespace pliant
