#include <gtest/gtest.h>

#include "physics/laws/elasticity.h"
#include "physics/laws/law.h"
#include "tests/physics/laws_cases.h"

namespace pliant {
namespace {

using namespace pliant::testing;

template <class T>
void expect_pack_equals_law(double spread, double tolerance) {
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
      const Material material;
      const Mat3d expected = kirchhoff_stress<double>({&material, mu[l], lambda[l]}, matrix[l], {});
      const double scale = tolerance * (mu[l] + lambda[l]) * (1 + std::pow(matrix[l].norm(), 6));
      const int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
      for (int k = 0; k < 6; ++k)
        EXPECT_NEAR(tau[k][l], expected(row[k], column[k]), scale) << "lane " << l << " det " << matrix[l].determinant();
    }
  }
}

TEST(FixedCorotated, FourAtOnceEqualOneByOne) {
  expect_pack_equals_law<double>(0.1, 1e-14);
  expect_pack_equals_law<float>(0.1, 2e-6);
}

TEST(FixedCorotated, FourAtOnceSurviveInvertedAndStretchedMatrices) {
  expect_pack_equals_law<double>(1.0, 1e-13);
  expect_pack_equals_law<float>(1.0, 1e-5);
}

}  // namespace
}  // namespace pliant
