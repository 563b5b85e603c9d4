// Stored energy and stress of every law.

#include <gtest/gtest.h>

#include "physics/laws/law.h"
#include "tests/check_adjoint.h"
#include "tests/physics/laws/laws_cases.h"

namespace pliant {
namespace {

using namespace pliant::fixture;

Mat3d map9(const std::vector<double>& x, int offset = 0) { return Eigen::Map<const Mat3d>(x.data() + offset); }

class Stress : public ::testing::TestWithParam<Law> {
 protected:
  Material material = material_of(GetParam());
  LawPoint<double> point{&material, kMu, kLambda};
  LawMemory<double> memory;

  Mat3d tau(const Mat3d& F) const { return kirchhoff_stress(point, F, memory); }
  Mat3d piola(const Mat3d& F) const { return tau(F) * F.transpose().inverse(); }
};

TEST_P(Stress, IsTheDerivativeOfTheEnergy) {
  int checked = 0;
  AdjointCheckOptions options;
  options.step = 1e-3;
  options.random_cotangents = 0;
  for (const Mat3d& F : smooth_states()) {
    if (smooth_margin(GetParam(), F) < 0.02) continue;
    memory.history = GetParam() == Law::kSnow ? -0.05 : 0.01;
    const auto energy = [&](const std::vector<double>& x) {
      return std::vector<double>{energy_density(point, map9(x), memory)};
    };
    const auto gradient = [&](const std::vector<double>& x, const std::vector<double>& adj) {
      const Mat3d P = adj[0] * piola(map9(x));
      return std::vector<double>(P.data(), P.data() + 9);
    };
    const Vec3d sigma = svd(F).sigma;
    if ((F.transpose() * F).isIdentity(1e-12)) {
      EXPECT_LT(tau(F).norm(), 1e-10 * kMu);  // at rest there is nothing to be relative to
      continue;
    }
    const AdjointCheck check = check_adjoint(energy, gradient, std::vector<double>(F.data(), F.data() + 9), options);
    EXPECT_LE(check.worst, 1e-6) << check.message << "\nstretches " << sigma.transpose();
    ++checked;
  }
  EXPECT_GE(checked, 60);
}

TEST_P(Stress, OfAnElasticLawIsTheSameInTheReferenceConfiguration) {
  if (!is_elastic(GetParam())) return;
  for (const Mat3d& F : smooth_states()) {
    const Mat3d P = piola_stress(point, F);
    EXPECT_LE((P * F.transpose() - tau(F)).norm(), 1e-12 * std::max(tau(F).norm(), kMu));
  }
  for (const double flat : {-1.0, -0.02, 0.0, 0.005}) {  // P has no tau there
    const Mat3d F = Vec3d(flat, 1.1, 1.2).asDiagonal();
    Mat3d other = F;
    other(0, 0) += 1e-5;
    const double slope =
        (energy_density<double>(point, other, memory) - energy_density<double>(point, F, memory)) / 1e-5;
    EXPECT_NEAR(piola_stress(point, F)(0, 0), slope, 2e-2 * std::abs(slope)) << flat;
  }
}

TEST_P(Stress, OfAnElasticLawHasTheDerivativesOfItsReferenceConfiguration) {
  if (!is_elastic(GetParam())) return;
  int checked = 0;
  AdjointCheckOptions options;
  options.step = 1e-3;
  const auto at = [&](const std::vector<double>& x) {
    return LawPoint<double>{&material, x[9] * kMu, x[10] * kLambda};
  };
  for (const Mat3d& F : smooth_states()) {
    if (smooth_margin(GetParam(), F) < 0.02) continue;
    std::vector<double> x(F.data(), F.data() + 9);
    x.insert(x.end(), {1.0, 1.0});
    const AdjointCheck check = check_adjoint(
        [&](const std::vector<double>& u) {
          const Mat3d P = piola_stress(at(u), map9(u)) / kMu;
          return std::vector<double>(P.data(), P.data() + 9);
        },
        [&](const std::vector<double>& u, const std::vector<double>& adj) {
          const LawGradient<double> g = piola_stress_adjoint<double>(at(u), map9(u), map9(adj) / kMu);
          std::vector<double> by(g.F.data(), g.F.data() + 9);
          by.insert(by.end(), {g.mu * kMu, g.lambda * kLambda});
          return by;
        },
        x, options);
    EXPECT_LE(check.worst, 1e-6) << check.message << "\nstretches " << svd(F).sigma.transpose();
    ++checked;
  }
  EXPECT_GE(checked, 60);
}

TEST_P(Stress, TurnsWithTheBody) {
  for (uint64_t i = 0; const Mat3d& F : smooth_states()) {
    const Mat3d R = random_rotation(++i), P = piola(F);
    EXPECT_LE((piola(R * F) - R * P).norm(), 1e-10 * std::max(P.norm(), kMu));
    EXPECT_NEAR(energy_density<double>(point, R * F, memory), energy_density<double>(point, F, memory),
                1e-10 * std::max(energy_density<double>(point, F, memory), kMu));
  }
}

TEST_P(Stress, DoesNotDependOnTheDirectionsOfTheMaterial) {
  for (uint64_t i = 0; const Mat3d& F : smooth_states()) {
    const Mat3d R = random_rotation(++i), P = piola(F);
    EXPECT_LE((piola(F * R) - P * R).norm(), 1e-10 * std::max(P.norm(), kMu));
  }
}

TEST_P(Stress, IsSymmetric) {
  for (int i = 0; i < 40; ++i) {
    memory.F_viscous = random_matrix(i + 100, 0.2);
    const Mat3d t = tau(random_matrix(i, 0.4));
    EXPECT_LE((t - t.transpose()).norm(), 1e-15 * t.norm());
  }
}

TEST_P(Stress, FollowsHookeAtSmallStrain) {
  Mat3d strain = random_matrix(5, 1.0) - 1.4 * Mat3d::Identity();
  strain = (0.5e-6 * (strain + strain.transpose())).eval();
  ASSERT_LT(strain.trace(), 0);  // a fluid bears no tension
  const double bulk = kLambda + 2 * kMu / 3;
  const Mat3d hooke = GetParam() == Law::kFluid
                          ? Mat3d(bulk * strain.trace() * Mat3d::Identity())
                          : Mat3d(2 * kMu * strain + kLambda * strain.trace() * Mat3d::Identity());
  EXPECT_LE((tau(Mat3d::Identity() + strain) - hooke).norm(), 2e-5 * hooke.norm());
}

TEST_P(Stress, PushesInvertedAndFlatStatesBack) {
  // Opening the flattest direction further lowers the energy until the state is upright.
  for (const double flat : {-1.0, -0.5, -0.02, 0.0, 0.005, 0.05}) {
    const Mat3d closed = Vec3d(flat, 1.1, 1.2).asDiagonal();
    const Mat3d open = Vec3d(flat + 1e-4, 1.1, 1.2).asDiagonal();
    EXPECT_LT(energy_density<double>(point, open, memory), energy_density<double>(point, closed, memory)) << flat;
  }
}

template <class T>
void expect_finite_everywhere(Law law) {
  const Material material = material_of(law);
  for (const T modulus : {T(1e2), T(1e11)}) {
    const LawPoint<T> point{&material, modulus, modulus};
    std::vector<Mat3d> states = {Mat3d::Zero(),
                                 Mat3d::Ones(),
                                 -Mat3d::Identity(),
                                 Vec3d(1, 0, 0).asDiagonal(),
                                 Vec3d(1, 1, 0).asDiagonal(),
                                 Vec3d(-1, 1, 1).asDiagonal(),
                                 Vec3d(1e8, 1e-8, 1).asDiagonal(),
                                 Vec3d(1e8, 1e8, -1e8).asDiagonal(),
                                 1e-20 * Mat3d::Identity()};
    for (int i = 0; i < 20; ++i)
      for (const double size : {1e-8, 1.0, 1e8}) states.push_back(size * random_matrix(i, 2.0));
    for (size_t i = 0; i < states.size(); ++i) {
      const Mat3<T> F = states[i].cast<T>(), other = states[states.size() - 1 - i].cast<T>();
      LawMemory<T> memory;
      memory.F_viscous = other;
      const Mat3<T> cotangent = random_matrix(i, 1.0).cast<T>();
      EXPECT_TRUE(std::isfinite(energy_density(point, F, memory))) << F;
      EXPECT_TRUE(kirchhoff_stress(point, F, memory).allFinite()) << F;
      const LawGradient<T> g = kirchhoff_stress_adjoint(point, F, memory, cotangent);
      EXPECT_TRUE(g.F.allFinite() && g.F_viscous.allFinite()) << F;
      EXPECT_TRUE(std::isfinite(g.history) && std::isfinite(g.mu) && std::isfinite(g.lambda)) << F;
      Mat3<T> mapped = F;
      LawMemory<T> after = memory;
      return_map(point, T(1e-4), mapped, after);
      EXPECT_TRUE(mapped.allFinite() && after.F_viscous.allFinite() && std::isfinite(after.history)) << F;
      EXPECT_TRUE(kirchhoff_stress(point, mapped, after).allFinite()) << F;
      LawGradient<T> adj;
      adj.F = cotangent;
      adj.F_viscous = cotangent;
      adj.history = 1;
      const LawGradient<T> back = return_map_adjoint(point, T(1e-4), F, memory, adj);
      EXPECT_TRUE(back.F.allFinite() && back.F_viscous.allFinite()) << F;
      EXPECT_TRUE(std::isfinite(back.history) && std::isfinite(back.mu) && std::isfinite(back.lambda)) << F;
    }
  }
}

TEST_P(Stress, AndReturnMapsAndAdjointsAreFiniteForAnyDeformation) {
  expect_finite_everywhere<double>(GetParam());
  expect_finite_everywhere<float>(GetParam());
}

INSTANTIATE_TEST_SUITE_P(Laws, Stress, ::testing::ValuesIn(kAllLaws),
                         [](const auto& info) { return law_name(info.param); });

TEST(Viscoelastic, BranchStressIsTheDerivativeOfItsEnergyAndTurnsWithTheBody) {
  const Material material = material_of(Law::kViscoelastic);
  const LawPoint<double> point{&material, kMu, kLambda};
  const Mat3d F = random_matrix(3, 0.1);
  const auto branch_tau = [&](const Mat3d& V) {
    return Mat3d(kirchhoff_stress(point, F, {Mat3d::Identity(), V, 0}) - kirchhoff_stress(point, F, {}));
  };
  AdjointCheckOptions options;
  options.step = 1e-3;
  for (int i = 0; i < 20; ++i) {
    const Mat3d V = random_matrix(i, 0.1), R = random_rotation(i);
    const AdjointCheck check = check_adjoint(
        [&](const std::vector<double>& x) {
          return std::vector<double>{energy_density(point, F, {Mat3d::Identity(), map9(x), 0})};
        },
        [&](const std::vector<double>& x, const std::vector<double>& adj) {
          const Mat3d P = adj[0] * branch_tau(map9(x)) * map9(x).transpose().inverse();
          return std::vector<double>(P.data(), P.data() + 9);
        },
        std::vector<double>(V.data(), V.data() + 9), options);
    EXPECT_LE(check.worst, 1e-6) << check.message;
    EXPECT_LE((branch_tau(R * V) - R * branch_tau(V) * R.transpose()).norm(), 1e-10 * kMu);
    EXPECT_LE((branch_tau(V * R) - branch_tau(V)).norm(), 1e-10 * kMu);
  }
}

TEST(SoundSpeed, IsThatOfTheRestStateWithAllBranches) {
  const double young = 1e5, poisson = 0.3, density = 800;
  const Lame<double> l = lame(young, poisson);
  const double p_wave = std::sqrt((l.lambda + 2 * l.mu) / density);
  for (const Law law : kAllLaws) {
    const Material m = material_of(law);
    const double c = sound_speed(m, young, poisson, density);
    switch (law) {
      case Law::kSnow:
        EXPECT_NEAR(c / p_wave, std::exp(1.5), 1e-12);
        break;
      case Law::kFluid:
        EXPECT_NEAR(c, std::sqrt(young / (3 * (1 - 2 * poisson)) / density), 1e-9);
        break;
      case Law::kViscoelastic:
        EXPECT_NEAR(c, std::sqrt((l.lambda + 2 * l.mu + 5e4) / density), 1e-9);
        break;
      default:
        EXPECT_NEAR(c, p_wave, 1e-9);
    }
  }
}

TEST(Viscosity, OfAFluidResistsShearAlone) {
  const Material fluid = material_of(Law::kFluid);
  const Viscosity<double> v = viscosity(LawPoint<double>{&fluid, kMu, kLambda});
  EXPECT_EQ(v.shear, fluid.dynamic_viscosity);
  EXPECT_NEAR(2 * v.shear + 3 * v.bulk, 0, 1e-15);  // stress of D = I
  Material damped;
  damped.viscosity_time = 1e-3;
  const Viscosity<double> k = viscosity(LawPoint<double>{&damped, kMu, kLambda});
  EXPECT_DOUBLE_EQ(k.shear, 1e-3 * kMu);
  EXPECT_DOUBLE_EQ(k.bulk, 1e-3 * kLambda);
}

}  // namespace
}  // namespace pliant
