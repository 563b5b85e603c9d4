// A torque on mass with any tensor of inertia.

#include "physics/simulate/inertia.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/check_adjoint.h"

namespace pliant {
namespace {

/// Of a rod of length 2 and mass 3 along the last column of a rotation, whose mass lies `thin` off its axis.
Mat3d rod(double thin, const Mat3d& rotation) {
  const Vec3d second(0.5 * thin * thin, thin * thin, 1);
  return rotation * (second.sum() * Mat3d::Identity() - Mat3d(second.asDiagonal())) * rotation.transpose();
}

const Mat3d kTurned = Eigen::AngleAxisd(0.7, Vec3d(1, 2, -1).normalized()).toRotationMatrix();
const Vec3d kTwist(0.3, -0.2, 0.5);

TEST(AngularAcceleration, TimesTheInertiaIsTheTorque) {
  for (const double thin : {1.0, 0.3, 0.05}) {
    const Mat3d inertia = rod(thin, kTurned);
    EXPECT_LT((inertia * angular_acceleration(inertia, kTwist) - kTwist).norm(), 1e-6) << thin;
  }
}

TEST(AngularAcceleration, OfALineOrAPointHasNoPartThatNothingResists) {
  const Mat3d line = rod(0, kTurned);
  const Vec3d axis = kTurned.col(2), across = kTwist - axis.dot(kTwist) * axis;
  const Vec3d found = angular_acceleration(line, kTwist);
  EXPECT_LT(std::abs(found.dot(axis)), 1e-3 * found.norm());
  EXPECT_LT((line * found - across).norm(), 1e-9);
  EXPECT_LT(angular_acceleration(line, axis).norm(), 1e-3);
  EXPECT_EQ(angular_acceleration(Mat3d::Zero(), kTwist), Vec3d::Zero());
}

TEST(AngularAcceleration, DerivativesAgreeWithDifferences) {
  // x: six entries of the tensor, then the torque.
  const auto tensor = [](const std::vector<double>& x) {
    Mat3d I;
    I << x[0], x[3], x[4], x[3], x[1], x[5], x[4], x[5], x[2];
    return I;
  };
  const auto torque = [](const std::vector<double>& x) { return Vec3d(x[6], x[7], x[8]); };
  for (const double thin : {1.0, 0.3, 0.1}) {
    const Mat3d I = rod(thin, kTurned);
    const std::vector<double> x = {I(0, 0), I(1, 1),    I(2, 2),    I(0, 1),   I(0, 2),
                                   I(1, 2), kTwist.x(), kTwist.y(), kTwist.z()};
    AdjointCheckOptions options;
    options.step = 1e-2 * thin * thin;
    const AdjointCheck result = check_adjoint(
        [&](const std::vector<double>& at) {
          const Vec3d b = angular_acceleration(tensor(at), torque(at));
          return std::vector<double>{b.x(), b.y(), b.z()};
        },
        [&](const std::vector<double>& at, const std::vector<double>& adj) {
          Mat3d A = Mat3d::Zero();
          Vec3d by_torque = Vec3d::Zero();
          angular_acceleration_adjoint(tensor(at), torque(at), Vec3d(adj[0], adj[1], adj[2]), A, by_torque);
          return std::vector<double>{A(0, 0),           A(1, 1),           A(2, 2),
                                     A(0, 1) + A(1, 0), A(0, 2) + A(2, 0), A(1, 2) + A(2, 1),
                                     by_torque.x(),     by_torque.y(),     by_torque.z()};
        },
        x, options);
    EXPECT_LT(result.worst, 1e-6) << thin << ": " << result.message;
  }
}

}  // namespace
}  // namespace pliant
