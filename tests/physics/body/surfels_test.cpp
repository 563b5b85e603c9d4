// Areas of surfaces that are known only by flat Gaussians.

#include "physics/body/surfels.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pliant {
namespace {

constexpr float kSpacing = 0.01f, kSigma = 0.005f, kLength = 1;

/// Rows of discs along x in the plane z = 0.
GaussianCloud strip(int rows) {
  GaussianCloud cloud;
  for (float x = 0; x < kLength; x += kSpacing)
    for (int row = 0; row < rows; ++row) {
      const size_t i = cloud.size();
      cloud.resize(i + 1);
      cloud.position[i] = Vec3f(x, kSpacing * static_cast<float>(row), 0);
      cloud.log_scale[i] = Vec3f(kSigma, kSigma, 0.05f * kSigma).array().log();
      cloud.rotation[i] = Vec4f(1, 0, 0, 0);
      cloud.opacity_logit[i] = 3;
    }
  return cloud;
}

TEST(Surfels, ANarrowStripHasTheAreaThatItsGaussiansCover) {
  for (const int rows : {1, 2, 3, 6, 20}) {
    double area = 0;
    for (const Surfel& s : make_surfels({}, strip(rows))) area += s.sheet_area;
    // A Gaussian counts as surface up to twice the root of the trace of its covariance.
    const double width = kSpacing * (rows - 1) + 2 * 2 * std::sqrt(2.0) * kSigma;
    EXPECT_NEAR(area / (width * kLength), 1, 0.2) << rows << " rows";
  }
}

}  // namespace
}  // namespace pliant
