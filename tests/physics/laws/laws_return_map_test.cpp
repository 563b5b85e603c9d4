// Return maps: yield surfaces, flow and relaxation against closed forms.

#include <gtest/gtest.h>

#include "physics/laws/law.h"
#include "tests/physics/laws/laws_cases.h"

namespace pliant {
namespace {

using namespace pliant::fixture;

Mat3d deviator(const Mat3d& A) { return A - A.trace() / 3 * Mat3d::Identity(); }

/// How far tau lies outside the yield surface, Pa; `law`'s own surface in Kirchhoff stress.
double excess(const Material& m, const Mat3d& tau, double history) {
  const double shear = deviator(tau).norm();
  switch (m.law) {
    case Law::kMetal:
    case Law::kPlasticine:
      return shear - std::sqrt(2.0 / 3) * std::max(0.0, m.yield_stress + m.hardening * history);
    case Law::kFoam:
      return shear - std::sqrt(2.0 / 3) * m.yield_stress;
    case Law::kSand: {
      const double s = std::sin(m.friction_angle * M_PI / 180);
      return shear + std::sqrt(2.0 / 3) * 2 * s / (3 - s) * tau.trace();
    }
    default:
      ADD_FAILURE();
      return 0;
  }
}

struct Body {
  Material material;
  Mat3d F;
  LawMemory<double> memory;

  Body(Law law, const Mat3d& F, double history = 0) : material(material_of(law)), F(F) { memory.history = history; }
  LawPoint<double> point() const { return {&material, kMu, kLambda}; }
  void map(double dt = 1e-3) { return_map(point(), dt, F, memory); }
  Mat3d tau() const { return kirchhoff_stress(point(), F, memory); }
};

std::vector<Mat3d> trials() {
  std::vector<Mat3d> F;
  for (int i = 0; i < 200; ++i) F.push_back(random_matrix(i, i < 50 ? 0.01 : i < 100 ? 0.1 : i < 150 ? 0.3 : 1.0));
  F.push_back(Mat3d::Identity());
  F.push_back(with_stretches(1, 1e-8, 1e-8, 1e-8));
  F.push_back(with_stretches(1, 1e-6, 1, 1e3));
  return F;
}

class Yield : public ::testing::TestWithParam<Law> {};

TEST_P(Yield, EndsOnOrInsideItsSurface) {
  int outside = 0;
  for (const Mat3d& F : trials()) {
    Body body(GetParam(), F);
    body.material.plastic_viscosity = 0;  // foam without rate: perfectly plastic
    outside += excess(body.material, body.tau(), 0) > 0;
    body.map();
    EXPECT_LE(excess(body.material, body.tau(), body.memory.history), 1e-9 * std::max(kMu, body.tau().norm()));
    EXPECT_GE(body.memory.history, 0);
  }
  EXPECT_GT(outside, 100);
}

TEST_P(Yield, MappedStatesStay) {
  for (const Mat3d& F : trials()) {
    Body body(GetParam(), F);
    body.material.plastic_viscosity = 0;
    body.map();
    Body again = body;
    again.map();
    EXPECT_LE((again.F - body.F).norm(), 1e-11 * body.F.norm());
    EXPECT_NEAR(again.memory.history, body.memory.history, 1e-11 * std::max(1.0, body.memory.history));
  }
}

TEST_P(Yield, FlowKeepsVolume) {
  for (const Mat3d& F : trials()) {
    const Vec3d sigma = svd(F).sigma;
    if (sigma[0] < 0.02) continue;  // flat states are lifted
    Body body(GetParam(), F);
    body.map();
    // Sand in tension remembers in its history the volume that its stretches have lost.
    const double remembered = GetParam() == Law::kSand ? body.memory.history : 0;
    EXPECT_NEAR(std::log(body.F.determinant()) + remembered, std::log(F.determinant()), 1e-11);
  }
}

TEST_P(Yield, TurnsWithTheBodyAndIgnoresDirectionsOfTheMaterial) {
  for (uint64_t i = 0; const Mat3d& F : trials()) {
    if (svd(F).sigma[0] < 0.02) continue;
    const Mat3d R = random_rotation(++i), Q = random_rotation(i + 500);
    Body body(GetParam(), F), turned(GetParam(), R * F * Q);
    body.map();
    turned.map();
    EXPECT_LE((turned.F - R * body.F * Q).norm(), 1e-10 * body.F.norm());
    EXPECT_NEAR(turned.memory.history, body.memory.history, 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(Laws, Yield, ::testing::Values(Law::kMetal, Law::kSand, Law::kFoam, Law::kPlasticine),
                         [](const auto& info) { return law_name(info.param); });

/// Stretches a bar along x, the sides free of stress, in small steps; returns tau_xx.
double pull(Body& body, double log_strain, int steps) {
  double side = 0;  // logarithmic strain of the sides, plastic and elastic
  const double step = log_strain / steps;
  for (int k = 0; k < steps; ++k) {
    // Secant on the side's trial strain until the side carries nothing.
    const auto side_stress = [&](double s) {
      Body trial = body;
      trial.F = Vec3d(std::exp(step), std::exp(s), std::exp(s)).asDiagonal() * body.F;
      trial.map();
      return trial.tau()(1, 1);
    };
    double a = 0, b = -0.5 * step, fa = side_stress(a), fb = side_stress(b);
    for (int it = 0; it < 40 && std::abs(fb) > 1e-9 * kMu && fa != fb; ++it) {
      const double c = b - fb * (b - a) / (fb - fa);
      a = b;
      fa = fb;
      b = c;
      fb = side_stress(c);
    }
    body.F = Vec3d(std::exp(step), std::exp(b), std::exp(b)).asDiagonal() * body.F;
    body.map();
    side += b;
  }
  return body.tau()(0, 0);
}

TEST(Metal, YieldsAtTheUniaxialYieldStressAndHardensInAPulledBar) {
  const double young = kMu * (3 * kLambda + 2 * kMu) / (kLambda + kMu);
  Body bar(Law::kMetal, Mat3d::Identity());
  const double yield = bar.material.yield_stress, hardening = bar.material.hardening;
  EXPECT_NEAR(pull(bar, 0.9 * yield / young, 10), 0.9 * yield, 1e-6 * yield);  // elastic until there
  EXPECT_EQ(bar.memory.history, 0);
  const double strain = 0.2;
  const double stress = pull(bar, strain - 0.9 * yield / young, 200);
  // eps = stress / E + eps_p, stress = yield + H eps_p.
  const double expected = yield + hardening * (strain - yield / young) / (1 + hardening / young);
  EXPECT_NEAR(stress, expected, 1e-6 * expected);
  EXPECT_NEAR(bar.memory.history, (expected - yield) / hardening, 1e-6);
}

TEST(Plasticine, SoftensWithPlasticStrainAndEndsAsAFluidThatKeepsItsVolume) {
  const double young = kMu * (3 * kLambda + 2 * kMu) / (kLambda + kMu);
  Body bar(Law::kPlasticine, Mat3d::Identity());
  const double yield = bar.material.yield_stress, softening = bar.material.hardening, strain = 0.12;
  const double stress = pull(bar, strain, 200);
  const double expected = yield + softening * (strain - yield / young) / (1 + softening / young);
  EXPECT_NEAR(stress, expected, 1e-6 * yield);
  // The yield stress is used up at eps_p = yield / |softening| = 0.25.
  Body spent(Law::kPlasticine, with_stretches(2, 1.02, 0.9, 1.1), 0.3);
  spent.map();
  EXPECT_LT(deviator(spent.tau()).norm(), 1e-10 * kMu);
  EXPECT_NEAR(spent.F.determinant(), 1.02 * 0.9 * 1.1, 1e-12);
  EXPECT_NEAR(spent.tau().trace() / 3, (kLambda + 2 * kMu / 3) * std::log(1.02 * 0.9 * 1.1), 1e-8 * kLambda);
}

TEST(Plasticine, SofteningSteeperThanTheElasticStressReleasesEverything) {
  Body body(Law::kPlasticine, with_stretches(2, 1.2, 0.9, 0.95));
  body.material.hardening = -4 * kMu;
  body.map();
  EXPECT_LT(deviator(body.tau()).norm(), 1e-10 * kMu);
  EXPECT_GT(body.memory.history, 0.05);
}

TEST(Sand, SeparatesFreelyAndBearsLoadOnlyWhenTheGapIsClosed) {
  Body body(Law::kSand, with_stretches(3, 1.05, 1.02, 1.1));
  const double gap = std::log(1.05 * 1.02 * 1.1);
  body.map();
  EXPECT_LT(body.tau().norm(), 1e-10 * kMu);
  EXPECT_NEAR(body.memory.history, gap, 1e-12);
  // Half of the gap pressed out: still nothing; the rest and a little more: pressure of the little more.
  body.F *= std::exp(-gap / 6);
  body.map();
  EXPECT_LT(body.tau().norm(), 1e-10 * kMu);
  EXPECT_NEAR(body.memory.history, gap / 2, 1e-12);
  body.F *= std::exp(-gap / 6 - 0.001);
  body.map();
  EXPECT_EQ(body.memory.history, 0);
  EXPECT_NEAR(body.tau().trace() / 3, -0.003 * (kLambda + 2 * kMu / 3), 1e-8 * kMu);
}

TEST(Sand, TriaxialCompressionFailsAtTheMohrCoulombRatio) {
  // On the cone's compression meridian (one large, two equal small pressures) alpha is chosen so that
  // sigma_1 / sigma_3 = (1 + sin phi) / (1 - sin phi).
  Body body(Law::kSand, Mat3d(Vec3d(0.6, 1.1, 1.1).asDiagonal()));
  body.map();
  const Mat3d tau = body.tau();
  const double s = std::sin(body.material.friction_angle * M_PI / 180);
  EXPECT_NEAR(tau(0, 0) / tau(1, 1), (1 + s) / (1 - s), 1e-9);
}

TEST(Snow, StretchesStayBetweenTheirBoundsAndTheRestIsRemembered) {
  for (const Mat3d& F : trials()) {
    const Vec3d before = svd(F).sigma;
    if (before[0] < 0.02 || before[2] > 3) continue;
    Body body(Law::kSnow, F, 0.1);
    body.map();
    const Vec3d sigma = svd(body.F).sigma;
    EXPECT_GE(sigma[0], 1 - body.material.critical_compression - 1e-12);
    EXPECT_LE(sigma[2], 1 + body.material.critical_stretch + 1e-12);
    EXPECT_NEAR(std::log(body.F.determinant()) + body.memory.history,
                std::clamp(0.1 + std::log(F.determinant()), -3.0, 3.1), 0.11);
    if (std::abs(std::log(F.determinant())) < 2) {
      EXPECT_NEAR(std::log(body.F.determinant()) + body.memory.history, 0.1 + std::log(F.determinant()), 1e-11);
    }
    Body again = body;
    again.map();
    EXPECT_LE((again.F - body.F).norm(), 1e-12);
    EXPECT_NEAR(again.memory.history, body.memory.history, 1e-12);
  }
}

TEST(Snow, HardensWhenCompactedAndSoftensWhenTornApart) {
  const Mat3d F = with_stretches(1, 0.99, 1.0, 1.005);
  const double fresh = Body(Law::kSnow, F, 0).tau().norm();
  EXPECT_NEAR(Body(Law::kSnow, F, std::log(0.9)).tau().norm() / fresh, std::exp(1.0), 1e-9);
  EXPECT_NEAR(Body(Law::kSnow, F, std::log(1.2)).tau().norm() / fresh, std::exp(-2.0), 1e-9);
  EXPECT_NEAR(Body(Law::kSnow, F, -2.9).tau().norm() / fresh, std::exp(3.0), 1e-9);
}

TEST(Foam, ExcessOfAHeldStrainDecaysInTheTimeViscosityOverTwoMu) {
  Body body(Law::kFoam, with_stretches(4, 1.2, 0.9, 0.95));
  const double time = body.material.plastic_viscosity / (2 * kMu), dt = time / 2000;
  const double start = excess(body.material, body.tau(), 0);
  double last = start;
  for (int k = 0; k < 4000; ++k) {
    body.map(dt);
    const double now = excess(body.material, body.tau(), 0);
    ASSERT_LT(now, last);
    last = now;
  }
  EXPECT_NEAR(last, start * std::exp(-2.0), 2e-3 * start * std::exp(-2.0));
  // Below the yield stress nothing flows.
  Body held(Law::kFoam, with_stretches(4, 1.01, 1.0, 0.995));
  const Mat3d F = held.F;
  ASSERT_LT(excess(held.material, held.tau(), 0), 0);
  held.map();
  EXPECT_EQ(held.F, F);
}

TEST(Viscoelastic, AHeldStrainDecaysWithOneTimeInShearAndOneInVolume) {
  Body body(Law::kViscoelastic, Mat3d::Identity());
  const Material& m = body.material;
  body.memory.F_viscous = with_stretches(4, 1.2, 0.9, 0.95);
  const double bulk = m.branch_lambda + 2 * m.branch_shear / 3;
  const double shear_time = m.branch_viscosity / (2 * m.branch_shear), bulk_time = m.branch_viscosity / (2 * bulk);
  const Mat3d start = body.tau();
  const double dt = shear_time / 2000;
  for (int k = 0; k < 2000; ++k) body.map(dt);
  const Mat3d end = body.tau();
  EXPECT_NEAR(deviator(end).norm() / deviator(start).norm(), std::exp(-1.0), 1e-3 * std::exp(-1.0));
  EXPECT_NEAR(end.trace() / start.trace(), std::exp(-shear_time / bulk_time), 1e-3 * std::exp(-shear_time / bulk_time));
  EXPECT_EQ(body.F, Mat3d::Identity());
}

TEST(Fluid, KeepsItsVolumeAndForgetsItsShape) {
  const Mat3d F = with_stretches(5, 0.8, 0.9, 1.3);
  Body body(Law::kFluid, F);
  const Mat3d before = body.tau();
  body.map();
  EXPECT_LE((body.F - std::cbrt(F.determinant()) * Mat3d::Identity()).norm(), 1e-14);
  EXPECT_LE((body.tau() - before).norm(), 1e-10 * kMu);
  const double K = kLambda + 2 * kMu / 3;
  EXPECT_NEAR(before(0, 0), -F.determinant() * K / 7 * (std::pow(F.determinant(), -7) - 1), 1e-9 * K);
  EXPECT_EQ(Body(Law::kFluid, with_stretches(5, 1.0, 1.1, 1.05)).tau().norm(), 0);
}

TEST(ElasticLaws, HaveNoReturnMap) {
  for (const Law law : {Law::kFixedCorotated, Law::kNeoHookean, Law::kHencky}) {
    Body body(law, random_matrix(1, 0.5), 0.2);
    const Mat3d F = body.F;
    body.map();
    EXPECT_EQ(body.F, F);
    EXPECT_EQ(body.memory.history, 0.2);
  }
}

}  // namespace
}  // namespace pliant
