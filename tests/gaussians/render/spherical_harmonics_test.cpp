// Derivatives of the spherical harmonics basis and of the colour it gives, for every degree.

#include "gaussians/render/spherical_harmonics.h"

#include <gtest/gtest.h>

#include "tests/check_adjoint.h"

namespace pliant {
namespace {

using Values = std::vector<double>;

class ShDegree : public testing::TestWithParam<int> {
 protected:
  int degree() const { return GetParam(); }
  int count() const { return (degree() + 1) * (degree() + 1); }
};

TEST_P(ShDegree, BasisAdjointAgreesWithDifferences) {
  const auto f = [&](const Values& x) {
    Values basis(count());
    sh_basis<double>(degree(), Vec3d(x[0], x[1], x[2]), basis.data());
    return basis;
  };
  const auto adjoint = [&](const Values& x, const Values& y) {
    Vec3d adj_d;
    sh_basis_adjoint<double>(degree(), Vec3d(x[0], x[1], x[2]), y.data(), adj_d);
    return Values(adj_d.data(), adj_d.data() + 3);
  };
  for (uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const Vec3d d = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
    const AdjointCheck check = check_adjoint(f, adjoint, {d[0], d[1], d[2]});
    EXPECT_LT(check.worst, 1e-9) << check.message;
  }
}

TEST_P(ShDegree, ColorAdjointAgreesWithDifferencesAndStopsAtTheClamp) {
  const auto f = [&](const Values& x) {
    const Vec3d color = sh_color<double>(degree(), x.data() + 3, Vec3d(x[0], x[1], x[2]));
    return Values(color.data(), color.data() + 3);
  };
  const auto adjoint = [&](const Values& x, const Values& y) {
    Values out(x.size());
    Vec3d adj_d;
    sh_color_adjoint<double>(degree(), x.data() + 3, Vec3d(x[0], x[1], x[2]), Vec3d(y[0], y[1], y[2]), out.data() + 3,
                             adj_d);
    std::copy(adj_d.data(), adj_d.data() + 3, out.begin());
    return out;
  };
  int clamped = 0, open = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    Random random(seed);
    Vec3d d(random.normal(), random.normal(), random.normal());
    d.normalize();
    Values x(d.data(), d.data() + 3);
    for (int k = 0; k < 3 * count(); ++k) x.push_back(random.normal());
    // No colour within reach of the differences from the clamp.
    const Values color = f(x);
    if (std::any_of(color.begin(), color.end(), [](double c) { return c > 0 && c < 0.1; })) continue;
    clamped += static_cast<int>(std::count(color.begin(), color.end(), 0.0));
    open += static_cast<int>(std::count_if(color.begin(), color.end(), [](double c) { return c > 0; }));
    const AdjointCheck check = check_adjoint(f, adjoint, x);
    EXPECT_LT(check.worst, 1e-8) << check.message;
  }
  EXPECT_GT(clamped, 2);
  EXPECT_GT(open, 5);
}

TEST(SphericalHarmonics, ColorAdjointTakesFloatCoefficientsInDouble) {
  float sh[48];
  double sh_double[48], a[48], b[48];
  for (int k = 0; k < 48; ++k) sh_double[k] = sh[k] = static_cast<float>(0.2 * Random(5, k).normal());
  const Vec3d d = Vec3d(0.3, -0.5, 0.8).normalized(), adj(1, -2, 0.5);
  Vec3d adj_a, adj_b;
  sh_color_adjoint<double>(3, sh, d, adj, a, adj_a);
  sh_color_adjoint<double>(3, sh_double, d, adj, b, adj_b);
  EXPECT_EQ(adj_a, adj_b);
  EXPECT_TRUE(std::equal(a, a + 48, b));
}

INSTANTIATE_TEST_SUITE_P(AllDegrees, ShDegree, testing::Range(0, 4));

}  // namespace
}  // namespace pliant
