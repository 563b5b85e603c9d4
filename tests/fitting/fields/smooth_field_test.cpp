#include "fitting/fields/smooth_field.h"

#include <gtest/gtest.h>

#include "gaussians/base/random.h"

namespace pliant {
namespace {

std::vector<Vec3f> points_of(int count) {
  std::vector<Vec3f> points;
  for (int i = 0; i < count; ++i) {
    Random random(3, i);
    points.push_back(Vec3f(static_cast<float>(random.uniform()), static_cast<float>(random.uniform()),
                           static_cast<float>(3 * random.uniform())));
  }
  return points;
}

TEST(SmoothField, ItsModesAddUpToTheCovarianceOfTheRandomField) {
  const std::vector<Vec3f> points = points_of(150);
  SmoothFieldOptions options;
  options.sigma = 0.7;
  options.length = 1.2;
  options.modes = 60;
  options.least = 1e-9;
  const SmoothField field(options, points);
  const Eigen::MatrixXd covariance = field.modes() * field.modes().transpose();
  for (size_t a = 0; a < points.size(); a += 7)
    for (size_t b = 0; b < points.size(); b += 11)
      EXPECT_NEAR(covariance(a, b), 0.49 * std::exp(-0.5 * (points[a] - points[b]).squaredNorm() / 1.44), 2e-3);
}

TEST(SmoothField, AdjointIsTheTransposeOfValuesAndSlopesAreDerivatives) {
  const std::vector<Vec3f> points = points_of(80);
  const SmoothField field({}, points);
  std::vector<double> p(field.parameters()), w(points.size());
  for (size_t i = 0; i < p.size(); ++i) p[i] = Random(1, i).normal();
  for (size_t i = 0; i < w.size(); ++i) w[i] = Random(2, i).normal();
  const auto values = field.values(p), adj = field.values_adjoint(p, w);
  double forward = 0, reverse = 0;
  for (size_t i = 0; i < w.size(); ++i) forward += w[i] * values[i];
  for (size_t i = 0; i < p.size(); ++i) reverse += p[i] * adj[i];
  EXPECT_NEAR(forward, reverse, 1e-9);

  const float h = 0.01f;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Vec3f> there = points, back = points;
    for (size_t i = 0; i < points.size(); ++i) {
      there[i][axis] += h;
      back[i][axis] -= h;
    }
    const Eigen::MatrixXd difference = (field.modes_at(there) - field.modes_at(back)) / (2 * h),
                          slope = field.slopes(points, axis);
    EXPECT_LT((difference - slope).norm(), 1e-3 * slope.norm());
  }
}

TEST(SmoothField, AConstantIsReachedAsNearlyAsItsModesCan) {
  const std::vector<Vec3f> points = points_of(120);
  const SmoothField field({}, points);
  for (const double v : field.values(field.constant(std::vector<double>{0.8}))) EXPECT_NEAR(v, 0.8, 0.08);
}

}  // namespace
}  // namespace pliant
