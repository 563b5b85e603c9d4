#include "gaussians/base/linear_algebra.h"

#include <gtest/gtest.h>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

Eigen::MatrixXd semidefinite(int n, int rank, Random& random) {
  Eigen::MatrixXd half(n, rank);
  for (double& x : half.reshaped()) x = random.normal();
  return half * half.transpose();
}

TEST(LinearAlgebra, EigenvectorsDiagonaliseInAscendingOrder) {
  Random random(3);
  for (const int n : {1, 3, 8, 40}) {
    const Eigen::MatrixXd A = semidefinite(n, n, random);
    const SymmetricEigen eigen = symmetric_eigen(A);
    EXPECT_LE((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm(), 1e-12 * A.norm());
    EXPECT_LE((eigen.vectors.transpose() * eigen.vectors - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-12 * n);
    for (int k = 1; k < n; ++k) EXPECT_LE(eigen.values[k - 1], eigen.values[k]);
    if (n == 3) {
      const SymmetricEigen3 fixed = symmetric_eigen3(Mat3d(A));
      EXPECT_LE((fixed.values - eigen.values).norm(), 1e-12 * A.norm());
      EXPECT_LE((A * fixed.vectors - fixed.vectors * fixed.values.asDiagonal()).norm(), 1e-12 * A.norm());
    }
  }
}

TEST(LinearAlgebra, SymmetricSystemsAreSolvedForSeveralRightSides) {
  Random random(4);
  for (const int n : {2, 3, 7, 30}) {
    const Eigen::MatrixXd A = semidefinite(n, 2 * n, random);
    Eigen::MatrixXd x(n, 3);
    for (double& value : x.reshaped()) value = random.normal();
    EXPECT_LE((solve_symmetric(A, A * x) - x).norm(), 1e-9 * x.norm());
  }
}

TEST(LinearAlgebra, ShortestRotationTurnsByTheAngleBetweenAlsoHalfATurn) {
  Random random(5);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3d from = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    Vec3d to = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    if (trial % 4 == 1) to = from;
    if (trial % 4 == 2) to = -from;
    if (trial % 4 == 3) to = (-from + 1e-5 * to).normalized();
    const Mat3d R = shortest_rotation<double>(from, to);
    EXPECT_LE((R * from - to).norm(), 1e-9);
    EXPECT_LE((R.transpose() * R - Mat3d::Identity()).norm(), 1e-9);
    EXPECT_NEAR(0.5 * (R.trace() - 1), from.dot(to), 1e-9);  // cosine of the angle
    EXPECT_LE(
        (shortest_rotation<float>(from.cast<float>(), to.cast<float>()) * from.cast<float>() - to.cast<float>()).norm(),
        2e-3f);
  }
}

}  // namespace
}  // namespace pliant
