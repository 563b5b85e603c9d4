// Laws of the polar decomposition, the symmetric eigenproblem and the singular value decomposition of 3 x 3 matrices,
// for well-conditioned, singular and inverted matrices.

#include "gaussians/base/polar.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

template <class T>
Mat3<T> random_matrix(Random& random) {
  Mat3<T> M;
  for (int i = 0; i < 9; ++i) M.data()[i] = static_cast<T>(random.normal());
  return M;
}

template <class T>
Mat3<T> random_rotation(Random& random) {
  Eigen::Quaternion<double> q(random.normal(), random.normal(), random.normal(), random.normal());
  return q.normalized().toRotationMatrix().cast<T>();
}

template <class T>
void expect_polar(const Mat3<T>& F, T tolerance) {
  const Polar<T> p = polar(F);
  const T scale = std::max(F.norm(), T(1e-30));
  EXPECT_LT((p.R.transpose() * p.R - Mat3<T>::Identity()).norm(), tolerance) << F;
  EXPECT_NEAR(p.R.col(0).cross(p.R.col(1)).dot(p.R.col(2)), T(1), tolerance) << F;
  EXPECT_LT((p.R * p.S - F).norm() / scale, tolerance) << F;
  // R maximises tr(R^T F) exactly when the two smallest eigenvalues of S have a non-negative sum.
  Vec3<T> value;
  Mat3<T> vector;
  symmetric_eigen<T, 3>(p.S, value, vector);
  EXPECT_GE((value[0] + value[1]) / scale, -tolerance) << F;
}

template <class T>
void expect_polar_of_all_kinds(T tolerance) {
  Random random(11);
  for (int i = 0; i < 2000; ++i) {
    const Mat3<T> M = random_matrix<T>(random);
    expect_polar<T>(M, tolerance);
    expect_polar<T>(M * T(1e-6), tolerance);
    Mat3<T> singular = M;
    singular.col(2) = singular.col(0) - singular.col(1);
    expect_polar<T>(singular, tolerance);
    expect_polar<T>(M.col(0) * M.col(1).transpose(), tolerance);
    Mat3<T> inverted = random_rotation<T>(random);
    inverted.row(i % 3) *= T(-0.3);
    expect_polar<T>(inverted, tolerance);
  }
  expect_polar<T>(Mat3<T>::Zero(), tolerance);
  expect_polar<T>(-Mat3<T>::Identity(), tolerance);
  expect_polar<T>(Vec3<T>(1, 1, 0).asDiagonal(), tolerance);
}

TEST(Polar, RotationTimesStretchIsFForEveryKindOfMatrixInDouble) { expect_polar_of_all_kinds<double>(1e-12); }
TEST(Polar, RotationTimesStretchIsFForEveryKindOfMatrixInFloat) { expect_polar_of_all_kinds<float>(3e-6f); }

TEST(Polar, RotationOfARotationIsItself) {
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const Mat3d R = random_rotation<double>(random);
    EXPECT_LT((polar_rotation<double>(R) - R).norm(), 1e-14);
    EXPECT_LT((polar_rotation<float>(R.cast<float>()) - R.cast<float>()).norm(), 1e-6f);
  }
}

TEST(Polar, BothAlgorithmsAgreeWhereBothApply) {
  Random random(13);
  for (int i = 0; i < 500; ++i) {
    const Mat3d F = random_rotation<double>(random) + 0.3 * random_matrix<double>(random);
    if (F.determinant() < 0.1) continue;
    EXPECT_LT((polar_rotation<double>(F) - closest_rotation<double>(F)).norm(), 1e-11);
  }
}

TEST(Polar, DerivativeAgreesWithCentralDifferencesAndIsItsOwnAdjoint) {
  Random random(14);
  for (int i = 0; i < 100; ++i) {
    const Mat3d F = random_rotation<double>(random) + 0.2 * random_matrix<double>(random);
    if (F.determinant() < 0.2) continue;
    const Mat3d dF = random_matrix<double>(random), gR = random_matrix<double>(random);
    const Polar<double> p = polar(F);
    const Mat3d dR = polar_rotation_derivative(p, dF);
    const double h = 1e-5;
    const Mat3d difference = (polar_rotation<double>(F + h * dF) - polar_rotation<double>(F - h * dF)) / (2 * h);
    EXPECT_LT((dR - difference).norm() / dR.norm(), 1e-6);
    EXPECT_NEAR((gR.transpose() * dR).trace(), (polar_rotation_derivative(p, gR).transpose() * dF).trace(), 1e-11);
  }
}

TEST(Svd, ReproducesTheMatrixWithRotationsOnBothSides) {
  Random random(15);
  for (int i = 0; i < 500; ++i) {
    const Mat3d F = random_matrix<double>(random);
    const Svd<double> s = svd<double>(F);
    EXPECT_LT((s.U * s.sigma.asDiagonal() * s.V.transpose() - F).norm(), 1e-12);
    EXPECT_NEAR(s.U.determinant(), 1.0, 1e-12);
    EXPECT_NEAR(s.V.determinant(), 1.0, 1e-12);
    EXPECT_LE(std::abs(s.sigma[0]), s.sigma[1] + 1e-12);
    EXPECT_LE(s.sigma[1], s.sigma[2]);
  }
}

}  // namespace
}  // namespace pliant
