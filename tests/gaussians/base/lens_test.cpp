// The lens: derivative, inverse, and agreement with OpenCV.

#include "gaussians/base/lens.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

namespace pliant {
namespace {

const Lens kLenses[] = {{0.06, -0.08, -0.001, 0.0002, 0, 0}, {-0.2, 0.05, 0.003, -0.002, 0.01, 0.02}, {}};

TEST(Lens, AgreesWithOpenCv) {
  for (const Lens& lens : kLenses) {
    const auto& [k1, k2, p1, p2, k3, k4] = lens;
    const std::vector<double> coefficients = {k1, k2, p1, p2, k3, k4, 0, 0};
    for (const Eigen::Vector2d& x : {Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(-0.5, 0.4), Eigen::Vector2d(0, 0)}) {
      std::vector<cv::Point2d> projected;
      cv::projectPoints(std::vector<cv::Point3d>{{x.x(), x.y(), 1}}, cv::Vec3d(), cv::Vec3d(), cv::Matx33d::eye(),
                        coefficients, projected);
      EXPECT_NEAR((distort(lens, x) - Eigen::Vector2d(projected[0].x, projected[0].y)).norm(), 0, 1e-12);
    }
  }
}

TEST(Lens, DerivativeIsThatOfCentralDifferences) {
  for (const Lens& lens : kLenses) {
    const Eigen::Vector2d x(0.37, -0.52);
    Eigen::Matrix2d derivative;
    distort(lens, x, &derivative);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d h = 1e-6 * Eigen::Vector2d::Unit(k);
      EXPECT_NEAR(((distort(lens, x + h) - distort(lens, x - h)) / 2e-6 - derivative.col(k)).norm(), 0, 1e-9);
    }
  }
}

TEST(Lens, UndistortIsTheInverseOfDistort) {
  for (const Lens& lens : kLenses) {
    for (double u = -0.6; u <= 0.6; u += 0.1) {
      for (double v = -0.6; v <= 0.6; v += 0.1) {
        const auto x = undistort(lens, distort(lens, {u, v}));
        ASSERT_TRUE(x);
        EXPECT_NEAR((*x - Eigen::Vector2d(u, v)).norm(), 0, 1e-9);
      }
    }
  }
}

TEST(Lens, HasNoInverseWhereItFoldsOver) {
  const Lens lens = {-0.5, 0, 0, 0, 0, 0};  // r - r³/2 is at most 0.544
  EXPECT_TRUE(undistort(lens, {0.5, 0}));
  EXPECT_FALSE(undistort(lens, {0.6, 0}));
}

TEST(Lens, ProjectAndUnprojectAreInverse) {
  Camera camera = look_at({1, 2, -3}, {0, 0, 0}, {0, -1, 0}, 640, 480, 500);
  camera.distortion = kLenses[0];
  const Eigen::Vector3d point(0.2, -0.3, 0.4);
  const auto pixel = project(camera, point);
  ASSERT_TRUE(pixel);
  const auto x = unproject(camera, *pixel);
  ASSERT_TRUE(x);
  const Eigen::Vector3d p = camera.cam_from_world * point;
  EXPECT_NEAR((*x - p.head<2>() / p.z()).norm(), 0, 1e-10);
  EXPECT_FALSE(project(camera, camera.centre() - camera.forward()));
}

}  // namespace
}  // namespace pliant
