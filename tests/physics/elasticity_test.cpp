#include <gtest/gtest.h>

#include "gaussians/base/random.h"
#include "physics/laws/elasticity.h"

namespace pliant {
namespace {

constexpr double kMu = 3e4, kLambda = 5e4;

Mat3d random_matrix(uint64_t element, double spread) {
  Random random(11, element);
  Mat3d F;
  for (int k = 0; k < 9; ++k) F(k / 3, k % 3) = (k % 4 == 0) + spread * random.normal();
  return F;
}

Mat3d random_rotation(uint64_t element) { return polar_rotation(random_matrix(element + 1000, 2.0)); }

TEST(FixedCorotated, PiolaStressIsTheDerivativeOfTheEnergy) {
  for (int i = 0; i < 60; ++i) {
    const Mat3d F = random_matrix(i, i < 40 ? 0.2 : 0.6);
    const Mat3d P = first_piola(Law::kFixedCorotated, F, kMu, kLambda);
    Mat3d numerical;
    const double h = 1e-5;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        Mat3d up = F, down = F;
        up(a, b) += h, down(a, b) -= h;
        numerical(a, b) = (energy_density(Law::kFixedCorotated, up, kMu, kLambda) -
                           energy_density(Law::kFixedCorotated, down, kMu, kLambda)) / (2 * h);
      }
    EXPECT_LT((P - numerical).norm(), 1e-6 * std::max(P.norm(), kMu)) << i << "\n" << F;
  }
}

TEST(FixedCorotated, StressIsObjective) {
  for (int i = 0; i < 50; ++i) {
    const Mat3d F = random_matrix(i, 0.3), R = random_rotation(i);
    const Mat3d P = first_piola(Law::kFixedCorotated, F, kMu, kLambda);
    const Mat3d turned = first_piola<double>(Law::kFixedCorotated, R * F, kMu, kLambda);
    EXPECT_LT((turned - R * P).norm(), 1e-12 * kMu * 10);
    EXPECT_NEAR(energy_density<double>(Law::kFixedCorotated, R * F, kMu, kLambda),
                energy_density(Law::kFixedCorotated, F, kMu, kLambda), 1e-12 * kMu * 10);
  }
}

TEST(FixedCorotated, RestAndRotationsCarryNoStress) {
  EXPECT_EQ(first_piola<double>(Law::kFixedCorotated, Mat3d::Identity(), kMu, kLambda).norm(), 0);
  EXPECT_EQ(energy_density<double>(Law::kFixedCorotated, Mat3d::Identity(), kMu, kLambda), 0);
  for (int i = 0; i < 20; ++i)
    EXPECT_LT(first_piola(Law::kFixedCorotated, random_rotation(i), kMu, kLambda).norm(), 1e-13 * kLambda * 10);
}

TEST(FixedCorotated, SmallStrainsFollowHooke) {
  Mat3d strain = 1e-6 * random_matrix(5, 1.0);
  strain = (0.5 * (strain + strain.transpose())).eval();
  const Mat3d hooke = 2 * kMu * strain + kLambda * strain.trace() * Mat3d::Identity();
  const Mat3d P = first_piola<double>(Law::kFixedCorotated, Mat3d::Identity() + strain, kMu, kLambda);
  EXPECT_LT((P - hooke).norm(), 1e-5 * hooke.norm());
}

template <class T>
void expect_pack_equals_piola(double spread, double tolerance) {
  for (int i = 0; i < 50; ++i) {
    Pack<T> F[9], mu, lambda, tau[6];
    Mat3d matrix[kLanes];
    for (int l = 0; l < kLanes; ++l) {
      matrix[l] = random_matrix(4 * i + l, spread);
      for (int k = 0; k < 9; ++k) F[k][l] = static_cast<T>(matrix[l](k / 3, k % 3));
      mu[l] = static_cast<T>(kMu * (l + 1)), lambda[l] = static_cast<T>(kLambda * (l + 1));
    }
    kirchhoff_stress_pack<T>(Law::kFixedCorotated, F, mu, lambda, tau);
    for (int l = 0; l < kLanes; ++l) {
      const Mat3d expected =
          first_piola<double>(Law::kFixedCorotated, matrix[l], mu[l], lambda[l]) * matrix[l].transpose();
      const double scale = tolerance * (mu[l] + lambda[l]) * (1 + std::pow(matrix[l].norm(), 6));
      const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(tau[k][l], expected(row[k], column[k]), scale) << "lane " << l << " det " << matrix[l].determinant();
    }
  }
}

TEST(FixedCorotated, FourAtOnceEqualPiolaTimesFTransposed) {
  expect_pack_equals_piola<double>(0.1, 1e-14);
  expect_pack_equals_piola<float>(0.1, 2e-6);
}

TEST(FixedCorotated, FourAtOnceSurviveInvertedAndStretchedMatrices) {
  expect_pack_equals_piola<double>(1.0, 1e-13);
  expect_pack_equals_piola<float>(1.0, 1e-5);
}

}  // namespace
}  // namespace pliant
