// Adjoints of stress and return map against differences, for every law.

#include <gtest/gtest.h>

#include <functional>

#include "physics/laws/law.h"
#include "tests/check_adjoint.h"
#include "tests/physics/laws/laws_cases.h"

namespace pliant {
namespace {

using namespace pliant::fixture;
using Values = std::vector<double>;

/// Inputs of a law as numbers of similar size: F, F_viscous, history, and mu, lambda and the constants of the relaxing
/// branch in units of their own.
struct Inputs {
  Mat3d F, F_viscous;
  double history, mu, lambda;
  Material material;

  Inputs(const Material& of, const Values& x)
      : F(Eigen::Map<const Mat3d>(x.data())),
        F_viscous(Eigen::Map<const Mat3d>(x.data() + 9)),
        history(x[18]),
        mu(kMu * x[19]),
        lambda(kLambda * x[20]),
        material(of) {
    material.branch_shear *= x[21];
    material.branch_lambda *= x[22];
    material.branch_viscosity *= x[23];
  }
  LawMemory<double> memory() const { return {Mat3d::Identity(), F_viscous, history}; }
  LawPoint<double> point() const { return {&material, mu, lambda}; }
};

Values inputs_of(const Mat3d& F, const Mat3d& F_viscous, double history) {
  Values x(F.data(), F.data() + 9);
  x.insert(x.end(), F_viscous.data(), F_viscous.data() + 9);
  x.insert(x.end(), {history, 1, 1, 1, 1, 1});
  return x;
}

Values values_of(const Material& material, const LawGradient<double>& g) {
  Values x(g.F.data(), g.F.data() + 9);
  x.insert(x.end(), g.F_viscous.data(), g.F_viscous.data() + 9);
  x.insert(x.end(), {g.history, g.mu * kMu, g.lambda * kLambda, g.branch.shear * material.branch_shear,
                     g.branch.lambda * material.branch_lambda, g.branch.viscosity * material.branch_viscosity});
  return x;
}

AdjointCheck check_stress(const Material& material, const Values& x) {
  AdjointCheckOptions options;
  options.step = 1e-3;
  return check_adjoint(
      [&](const Values& x) {
        const Inputs in(material, x);
        const Mat3d tau = kirchhoff_stress(in.point(), in.F, in.memory());
        return Values(tau.data(), tau.data() + 9);
      },
      [&](const Values& x, const Values& adj) {
        const Inputs in(material, x);
        const Mat3d adj_tau = Eigen::Map<const Mat3d>(adj.data());
        return values_of(material, kirchhoff_stress_adjoint(in.point(), in.F, in.memory(), adj_tau));
      },
      x, options);
}

AdjointCheck check_return_map(const Material& material, double dt, const Values& x) {
  AdjointCheckOptions options;
  options.step = 1e-3;
  return check_adjoint(
      [&](const Values& x) {
        const Inputs in(material, x);
        Mat3d F = in.F;
        LawMemory<double> memory = in.memory();
        return_map(in.point(), dt, F, memory);
        Values y(F.data(), F.data() + 9);
        y.insert(y.end(), memory.F_viscous.data(), memory.F_viscous.data() + 9);
        y.push_back(memory.history);
        return y;
      },
      [&](const Values& x, const Values& y) {
        const Inputs in(material, x);
        LawGradient<double> adj;
        adj.F = Eigen::Map<const Mat3d>(y.data());
        adj.F_viscous = Eigen::Map<const Mat3d>(y.data() + 9);
        adj.history = y[18];
        return values_of(material, return_map_adjoint(in.point(), dt, in.F, in.memory(), adj));
      },
      x, options);
}

class Adjoint : public ::testing::TestWithParam<Law> {};

TEST_P(Adjoint, OfStress) {
  const Material material = material_of(GetParam());
  int checked = 0;
  for (uint64_t i = 0; const Mat3d& F : smooth_states()) {
    ++i;
    if (smooth_margin(GetParam(), F) < 0.02) continue;
    const AdjointCheck check = check_stress(material, inputs_of(F, random_matrix(i + 200, 0.15), -0.05));
    EXPECT_LE(check.worst, 1e-6) << check.message << "\nstretches " << svd(F).sigma.transpose();
    ++checked;
  }
  EXPECT_GE(checked, 60);
}

TEST(AsPhysGaussian, StressIsHenckysTimesTheStretchAndItsAdjointIsExact) {
  for (const Law law : {Law::kMetal, Law::kFoam, Law::kSnow}) {
    Material material = material_of(law);
    material.as_physgaussian = true;
    const LawPoint<double> point{&material, kMu, kLambda};
    const Vec3d stretch(1.2, 0.9, 1.05), e = stretch.array().log().matrix();
    const Mat3d tau = kirchhoff_stress(point, Mat3d(stretch.asDiagonal()), LawMemory<double>{});
    for (int i = 0; i < 3; ++i) {
      const double expected = law == Law::kSnow ? 0 : stretch[i] * (2 * kMu * e[i] + kLambda * e.sum());
      EXPECT_NEAR(tau(i, i), expected, 1e-9 * kMu);
    }
    for (uint64_t i = 0; const Mat3d& F : smooth_states()) {
      ++i;
      if (law == Law::kSnow || smooth_margin(law, F) < 0.02) continue;
      const AdjointCheck check = check_stress(material, inputs_of(F, random_matrix(i + 200, 0.15), 0));
      EXPECT_LE(check.worst, 1e-6) << check.message << "\nstretches " << svd(F).sigma.transpose();
    }
  }
}

/// Trial states by their principal stretches, in every regime of the return map and clear of the borders between them.
struct Trial {
  Vec3d sigma;
  double history;
};
std::vector<Trial> trials(Law law) {
  switch (law) {
    case Law::kMetal:
      return {{{1.01, 1.0, 0.99}, 0}, {{1.1, 0.95, 0.9}, 0},  {{1.5, 1.2, 0.6}, 0.3},  {{1.1, 1.1, 1.1}, 0},
              {{1.2, 0.9, 0.9}, 0.1}, {{1.2, 1.2, 0.7}, 0.1}, {{1.3, 0.8, -0.4}, 0.1}, {{1.3, 1.3, 0.004}, 0}};
    case Law::kPlasticine:
      return {{{1.01, 1.0, 0.99}, 0},  {{1.1, 0.95, 0.9}, 0},  {{1.5, 1.2, 0.6}, 0.1}, {{1.5, 1.1, 0.7}, 0.4},
              {{1.2, 0.9, 0.9}, 0.05}, {{1.2, 0.9, 0.9}, 0.3}, {{1.3, 0.8, -0.4}, 0.1}};
    case Law::kSand:
      return {{{0.94, 0.95, 0.96}, 0}, {{1.1, 0.8, 0.9}, 0},       {{1.1, 1.2, 1.05}, 0},
              {{1.1, 0.8, 0.9}, 0.05}, {{0.93, 0.93, 0.96}, 0.02}, {{0.9, 0.9, 0.9}, 0.05},
              {{0.8, 0.8, 1.1}, 0},    {{1.1, 1.1, 1.1}, 0.2},     {{1.1, 0.8, -0.3}, 0}};
    case Law::kSnow:
      return {{{0.99, 1.0, 1.003}, 0}, {{0.9, 1.0, 1.003}, 0.1}, {{0.9, 0.9, 1.1}, 0},  {{1.2, 1.2, 1.2}, -0.3},
              {{0.8, 0.85, 0.9}, 0.2}, {{0.99, 0.99, 1.1}, 0},   {{0.99, 1.2, -0.5}, 0}};
    case Law::kFoam:
      return {{{1.01, 1.0, 0.99}, 0},
              {{1.1, 0.95, 0.9}, 0},
              {{1.5, 1.2, 0.6}, 0},
              {{1.2, 0.9, 0.9}, 0},
              {{1.3, 0.8, -0.4}, 0}};
    case Law::kFluid:
      return {{{0.9, 1.0, 1.05}, 0}, {{0.9, 0.9, 0.9}, 0}, {{1.5, 1.1, 1.1}, 0}, {{-0.5, 1, 1}, 0}};
    default:
      return {{{0.9, 1.0, 1.05}, 0}, {{1.2, 1.2, 0.7}, 0}, {{1.2, 1.2, 1.2}, 0}, {{1, 1, 1}, 0}, {{1.3, 0.8, -0.4}, 0}};
  }
}

TEST_P(Adjoint, OfTheReturnMap) {
  const Material material = material_of(GetParam());
  for (const Trial& trial : trials(GetParam())) {
    for (int turn = 0; turn < 4; ++turn) {
      const Mat3d F = with_stretches(turn, trial.sigma[0], trial.sigma[1], trial.sigma[2]);
      // Viscoelasticity maps its branch alone.
      const AdjointCheck check = check_return_map(material, 2e-3, inputs_of(F, F, trial.history));
      EXPECT_LE(check.worst, 1e-6) << check.message << "\nstretches " << trial.sigma.transpose() << " history "
                                   << trial.history;
    }
  }
}

TEST(ReturnMapAdjoint, PassesElasticStatesThrough) {
  for (const Law law : kAllLaws) {
    // These read their memory in every state.
    if (law == Law::kViscoelastic || law == Law::kFluid || law == Law::kSand) continue;
    const Material material = material_of(law);
    const Mat3d F = with_stretches(3, 1.001, 1, 0.999);
    LawGradient<double> adj;
    adj.F = random_matrix(1, 1.0);
    adj.F_viscous = random_matrix(2, 1.0);
    adj.history = 3;
    const LawGradient<double> g = return_map_adjoint({&material, kMu, kLambda}, 1e-3, F, LawMemory<double>{}, adj);
    EXPECT_EQ(g.F, adj.F) << law_name(law);
    EXPECT_EQ(g.F_viscous, adj.F_viscous);
    EXPECT_EQ(g.history, adj.history);
    EXPECT_EQ(g.mu, 0);
    EXPECT_EQ(g.lambda, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, Adjoint, ::testing::ValuesIn(kAllLaws),
                         [](const auto& info) { return law_name(info.param); });

TEST(Snow, StressAdjointIsExactWhereHardeningHasReachedItsBound) {
  const Material material = material_of(Law::kSnow);
  for (const double history : {-2.0, -0.5, -0.1, 0.3, 2.0}) {
    const AdjointCheck check = check_stress(material, inputs_of(random_matrix(4, 0.01), Mat3d::Identity(), history));
    EXPECT_LE(check.worst, 1e-6) << check.message << " history " << history;
  }
}

}  // namespace
}  // namespace pliant
