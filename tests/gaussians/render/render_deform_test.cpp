// Laws of binding and deformation: rigid motions of the drivers move Gaussians exactly, cords do not spin, gaps are not
// crossed, spherical harmonics turn with the Gaussian.

#include <gtest/gtest.h>

#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "gaussians/render/bind.h"
#include "gaussians/render/deform.h"
#include "gaussians/render/deform_kernels.h"
#include "gaussians/render/render.h"
#include "gaussians/render/spherical_harmonics.h"
#include "gaussians/render/splat_kernels.h"
#include "tests/gaussians/render/random_gaussians.h"

namespace pliant {
namespace {

Mat3d random_rotation(uint64_t seed) {
  Random random(seed);
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized()
      .toRotationMatrix();
}

GaussianCloud random_small_cloud(int n, int degree, uint64_t seed) {
  return fixture::random_cloud(n, degree, seed,
                               {.half_width = 0.5,
                                .min_log_scale = -6,
                                .max_log_scale = -2.5,
                                .min_opacity_logit = -2,
                                .max_opacity_logit = 4,
                                .color = 0.4,
                                .shine = 0.4});
}

std::vector<Vec3f> lattice(int n, float spacing) {
  std::vector<Vec3f> points;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) points.push_back(spacing * (Vec3f(x, y, z) - Vec3f::Constant(0.5f * (n - 1))));
  return points;
}

std::vector<Vec3f> moved_points(const std::vector<Vec3f>& points, const Mat3f& A, const Vec3f& t) {
  std::vector<Vec3f> out;
  for (const Vec3f& x : points) out.push_back(A * x + t);
  return out;
}

Mat3f covariance(const GaussianCloud& cloud, size_t i) {
  const Mat3f A = covariance_factor<float>(cloud.rotation[i], cloud.log_scale[i]);
  return A * A.transpose();
}

TEST(SphericalHarmonics, RotatedCoefficientsAtDAreTheOriginalsAtTheTransposeTimesD) {
  const ShRotation<double> rotation;
  const ShRotation<float> rotation_float;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const Mat3d R = random_rotation(seed);
    Random random(100 + seed);
    double sh[48];
    float sh_float[48];
    for (int k = 0; k < 48; ++k) sh_float[k] = static_cast<float>(sh[k] = random.normal());
    double rotated[48];
    std::copy(sh, sh + 48, rotated);
    rotation.apply(R, 3, rotated);
    rotation_float.apply(R.cast<float>(), 3, sh_float);
    for (int trial = 0; trial < 10; ++trial) {
      const Vec3d d = Vec3d(random.normal(), random.normal(), random.normal()).normalized();
      double at_d[16], at_back[16];
      sh_basis<double>(3, d, at_d);
      sh_basis<double>(3, R.transpose() * d, at_back);
      for (int l = 0; l <= 3; ++l) {  // band by band
        double left = 0, right = 0, single = 0;
        for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
          left += at_d[k] * rotated[3 * k + 1];
          right += at_back[k] * sh[3 * k + 1];
          single += at_d[k] * sh_float[3 * k + 1];
        }
        EXPECT_NEAR(left, right, 1e-13) << "degree " << l;
        EXPECT_NEAR(single, right, 5e-6) << "degree " << l;
      }
    }
  }
}

TEST(Bind, WeightsSumToOneAndNamesAreValid) {
  const GaussianCloud cloud = random_small_cloud(2000, 0, 1);
  const std::vector<Vec3f> drivers = lattice(6, 0.2f);
  const Binding binding = pliant::bind({}, cloud.position, drivers);
  for (size_t g = 0; g < binding.size(); ++g) {
    float sum = 0;
    for (int k = 0; k < Binding::kCount; ++k) {
      const int d = binding.driver[g * Binding::kCount + k];
      ASSERT_LT(d, static_cast<int>(drivers.size()));
      if (d >= 0) {
        EXPECT_LT((drivers[d] - cloud.position[g]).norm(), 0.5f);
      }
      sum += binding.weight[g * Binding::kCount + k];
    }
    EXPECT_NEAR(sum, 1.0f, 1e-5f);
  }
}

TEST(Bind, DriversBeyondAGapAreNotTaken) {
  // Two parallel sheets, 2.5 spacings apart: a Gaussian on one, even when it leans to the other, follows its own.
  std::vector<Vec3f> drivers;
  for (int sheet = 0; sheet < 2; ++sheet)
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y) drivers.push_back(Vec3f(0.1f * x, 0.1f * y, 0.25f * sheet));
  const std::vector<Vec3f> gaussians = {
      {0.4f, 0.4f, 0.0f}, {0.42f, 0.37f, 0.11f}, {0.42f, 0.37f, 0.14f}, {0, 0, 0.12f}};
  const std::vector<int> sheet = {0, 0, 1, 0};
  BindOptions options;
  options.spacing = 0.1f;
  const Binding binding = pliant::bind(options, gaussians, drivers);
  for (size_t g = 0; g < gaussians.size(); ++g)
    for (int k = 0; k < Binding::kCount; ++k) {
      ASSERT_GE(binding.driver[g * Binding::kCount + k], 0);
      EXPECT_EQ(binding.driver[g * Binding::kCount + k] / 81, sheet[g]) << "Gaussian " << g;
    }
}

TEST(Bind, LinksSayWhatHangsTogetherAtAnyDistance) {
  // Two parallel sheets, half a spacing apart; each Gaussian is known to show one of them.
  std::vector<Vec3f> drivers;
  std::vector<std::array<int, 2>> links;
  for (int sheet = 0; sheet < 2; ++sheet)
    for (int x = 0; x < 9; ++x)
      for (int y = 0; y < 9; ++y) {
        const int here = static_cast<int>(drivers.size());
        if (y > 0) links.push_back({here - 1, here});
        if (x > 0) links.push_back({here - 9, here});
        drivers.push_back(Vec3f(0.1f * x, 0.1f * y, 0.05f * sheet));
      }
  std::sort(links.begin(), links.end());
  const std::vector<Vec3f> gaussians = {{0.42f, 0.37f, 0.02f}, {0.42f, 0.37f, 0.02f}, {0, 0, 0.04f}};
  const std::vector<int> own = {4 * 9 + 4, 81 + 4 * 9 + 4, 0}, sheet = {0, 1, 0};
  const Binding binding = pliant::bind({}, gaussians, drivers, {.links = links, .own = own});
  for (size_t g = 0; g < gaussians.size(); ++g) {
    float sum = 0;
    for (int k = 0; k < Binding::kCount; ++k) {
      ASSERT_GE(binding.driver[g * Binding::kCount + k], 0);
      EXPECT_EQ(binding.driver[g * Binding::kCount + k] / 81, sheet[g]) << "Gaussian " << g;
      sum += binding.weight[g * Binding::kCount + k];
    }
    EXPECT_NEAR(sum, 1, 1e-5);
  }
}

TEST(Bind, GaussiansOutOfReachAndEmptyDriversStayUnbound) {
  const std::vector<Vec3f> drivers = lattice(3, 0.1f),
                           gaussians = {{0, 0, 0}, {0.1f, 0, 0.35f}, {0, 0, 5}, {NAN, 0, 0}};
  const Binding binding = pliant::bind({}, gaussians, drivers);
  EXPECT_GE(binding.driver[0], 0);
  EXPECT_GE(binding.driver[8], 0);
  EXPECT_EQ(binding.driver[16], -1);
  EXPECT_EQ(binding.driver[24], -1);
  EXPECT_EQ(pliant::bind({}, gaussians, {}).driver[0], -1);
  const std::vector<Vec3f> single = {{0, 0, 0}};
  EXPECT_EQ(pliant::bind({}, gaussians, single).weight[0], 1.0f);
}

TEST(Bind, WeightsAreContinuousAlongAPath) {
  const std::vector<Vec3f> drivers =
      moved_points(lattice(7, 0.1f), random_rotation(3).cast<float>(), Vec3f(0.013f, 0.027f, 0.008f));
  std::vector<Vec3f> path;
  for (int i = 0; i <= 4000; ++i) path.push_back(Vec3f(-0.1f, -0.05f, 0.02f) + i / 4000.0f * Vec3f(0.2f, 0.11f, 0.05f));
  const Binding binding = pliant::bind({}, path, drivers);
  std::vector<float> before(drivers.size()), now(drivers.size());
  for (size_t g = 0; g < path.size(); ++g) {
    std::fill(now.begin(), now.end(), 0.0f);
    for (int k = 0; k < Binding::kCount; ++k)
      if (const int d = binding.driver[g * Binding::kCount + k]; d >= 0)
        now[d] = binding.weight[g * Binding::kCount + k];
    for (size_t d = 0; g > 0 && d < drivers.size(); ++d) {
      ASSERT_NEAR(now[d], before[d], 0.01f);
    }
    before = now;
  }
}

class RigidMotion : public testing::TestWithParam<bool> {};

TEST_P(RigidMotion, MovesPositionCovarianceAndColourExactly) {
  const GaussianCloud rest = random_small_cloud(3000, 3, 2);
  const std::vector<Vec3f> drivers = lattice(6, 0.2f);
  const Binding binding = pliant::bind({}, rest.position, drivers);
  const Mat3d R = random_rotation(4);
  const Vec3d t(0.3, -0.2, 0.5);
  const std::vector<Mat3f> F(drivers.size(), R.cast<float>());
  DeformOptions options;
  options.stretch = GetParam();
  GaussianCloud out;
  deform(options, rest, binding, drivers, moved_points(drivers, R.cast<float>(), t.cast<float>()), F, out);
  for (size_t i = 0; i < rest.size(); ++i) {
    EXPECT_LT((out.position[i].cast<double>() - (R * rest.position[i].cast<double>() + t)).norm(), 1e-6);
    const Mat3d expected = R * covariance(rest, i).cast<double>() * R.transpose();
    EXPECT_LT((covariance(out, i).cast<double>() - expected).norm() / expected.norm(), 2e-6);
    Vec3f a = rest.log_scale[i], b = out.log_scale[i];
    std::sort(a.data(), a.data() + 3);
    std::sort(b.data(), b.data() + 3);
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 2e-5f) << "lengths of thin Gaussians keep their precision";
    EXPECT_EQ(out.opacity_logit[i], rest.opacity_logit[i]);
  }
  // A camera that moves along sees the same picture.
  const Camera camera = look_at({1.1, -1.4, 0.7}, {0, 0, 0}, {0, 0, 1}, 80, 60, 90);
  Camera follows = camera;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  motion.linear() = R;
  motion.translation() = t;
  follows.cam_from_world = camera.cam_from_world * motion.inverse();
  const RenderResult before = render(rest, camera), after = render(out, follows);
  int different = 0;
  for (size_t i = 0; i < before.color.data.size(); ++i)
    different += std::abs(before.color.data[i] - after.color.data[i]) > 5e-4f;
  EXPECT_LE(different, 5) << "only pixels at a threshold may differ";
}

INSTANTIATE_TEST_SUITE_P(StretchOnAndOff, RigidMotion, testing::Bool());

TEST(Deform, DriversOnALineDoNotSpin) {
  // A straight cord with Gaussians around it bends slightly and travels: nothing may turn about the cord.
  std::vector<Vec3f> drivers, now;
  for (int i = 0; i < 30; ++i) {
    const float s = 0.05f * i;
    drivers.push_back(Vec3f(s, 0, 0));
    now.push_back(Vec3f(std::sin(0.2f * s) / 0.2f, 0, (1 - std::cos(0.2f * s)) / 0.2f));
  }
  std::vector<Mat3f> F;
  for (int i = 0; i < 30; ++i) F.push_back(Eigen::AngleAxisf(-0.2f * 0.05f * i, Vec3f::UnitY()).toRotationMatrix());
  GaussianCloud rest = random_small_cloud(400, 0, 5);
  for (size_t i = 0; i < rest.size(); ++i)
    rest.position[i] = Vec3f(0.2f + 2.0f * (rest.position[i][0] + 0.5f) * 0.5f, 0.04f * rest.position[i][1],
                             0.04f * rest.position[i][2]);
  const Binding binding = pliant::bind({}, rest.position, drivers);
  GaussianCloud out;
  deform({}, rest, binding, drivers, now, F, out);
  for (size_t i = 0; i < rest.size(); ++i) {
    const float angle = 0.2f * rest.position[i][0];
    const Mat3f R = Eigen::AngleAxisf(-angle, Vec3f::UnitY()).toRotationMatrix();
    const Vec3f on_cord(std::sin(angle) / 0.2f, 0, (1 - std::cos(angle)) / 0.2f);
    const Vec3f expected = on_cord + R * Vec3f(0, rest.position[i][1], rest.position[i][2]);
    EXPECT_LT((out.position[i] - expected).norm(), 2e-3f);
  }
}

TEST(Deform, TwistOfACordIsThatOfItsDeformationGradients) {
  std::vector<Vec3f> drivers;
  for (int i = 0; i < 20; ++i) drivers.push_back(Vec3f(0.05f * i, 0, 0));
  const Mat3f twist = Eigen::AngleAxisf(0.7f, Vec3f::UnitX()).toRotationMatrix();
  const std::vector<Mat3f> F(drivers.size(), twist);
  GaussianCloud rest = random_small_cloud(1, 0, 6), out;
  rest.position[0] = Vec3f(0.5f, 0.02f, 0.01f);
  deform({}, rest, pliant::bind({}, rest.position, drivers), drivers, drivers, F, out);
  EXPECT_LT((out.position[0] - twist * rest.position[0]).norm(), 1e-6f);
}

TEST(Deform, AffineMotionStretchesTheCovariance) {
  const GaussianCloud rest = random_small_cloud(300, 0, 7);
  const std::vector<Vec3f> drivers = lattice(6, 0.2f);
  Mat3f A;
  A << 1.2f, 0.1f, 0, 0.05f, 0.9f, -0.1f, 0.02f, 0.1f, 1.1f;
  const std::vector<Mat3f> F(drivers.size(), A);
  GaussianCloud out;
  deform({}, rest, pliant::bind({}, rest.position, drivers), drivers, moved_points(drivers, A, Vec3f::Zero()), F, out);
  for (size_t i = 0; i < rest.size(); ++i) {
    const Mat3f expected = A * covariance(rest, i) * A.transpose();
    EXPECT_LT((covariance(out, i) - expected).norm() / expected.norm(), 3e-6f);
    EXPECT_NEAR(out.rotation[i].norm(), 1.0f, 1e-5f);
  }
}

TEST(Deform, MeanDisplacementMovesWithoutTurningPositions) {
  const GaussianCloud rest = random_small_cloud(50, 0, 8);
  const std::vector<Vec3f> drivers = lattice(6, 0.2f);
  std::vector<Vec3f> now = drivers;
  for (Vec3f& x : now) x += Vec3f(0.1f, 0.2f, 0.3f);
  DeformOptions options;
  options.mean_displacement = true;
  GaussianCloud out;
  deform(options, rest, pliant::bind({}, rest.position, drivers), drivers, now,
         std::vector<Mat3f>(drivers.size(), Mat3f::Identity()), out);
  for (size_t i = 0; i < rest.size(); ++i)
    EXPECT_LT((out.position[i] - rest.position[i] - Vec3f(0.1f, 0.2f, 0.3f)).norm(), 1e-6f);
}

TEST(Deform, UnboundGaussiansStayBitEqualAndThreadsDoNotMatter) {
  const GaussianCloud rest = random_small_cloud(5000, 3, 9);
  const std::vector<Vec3f> drivers = lattice(4, 0.15f);
  BindOptions bind_options;
  bind_options.max_reach = 0.6f;
  const Binding binding = pliant::bind(bind_options, rest.position, drivers);
  std::vector<Vec3f> now = drivers;
  std::vector<Mat3f> F(drivers.size());
  for (size_t i = 0; i < now.size(); ++i) {
    Random random(10, i);
    for (int k = 0; k < 3; ++k) now[i][k] += static_cast<float>(0.03 * random.normal());
    for (int k = 0; k < 9; ++k) F[i].data()[k] = static_cast<float>((k % 4 == 0) + 0.2 * random.normal());
  }
  const int before = omp_get_max_threads();
  GaussianCloud one, many;
  omp_set_num_threads(1);
  deform({}, rest, binding, drivers, now, F, one);
  omp_set_num_threads(3);
  deform({}, rest, binding, drivers, now, F, many);
  const Binding again = pliant::bind(bind_options, rest.position, drivers);
  omp_set_num_threads(before);
  EXPECT_EQ(binding.driver, again.driver);
  EXPECT_EQ(binding.weight, again.weight);
  EXPECT_EQ(one.sh, many.sh);
  int still = 0;
  for (size_t i = 0; i < rest.size(); ++i) {
    EXPECT_EQ(one.position[i], many.position[i]);
    EXPECT_EQ(one.rotation[i], many.rotation[i]);
    EXPECT_EQ(one.log_scale[i], many.log_scale[i]);
    if (binding.driver[i * Binding::kCount] >= 0) continue;
    ++still;
    EXPECT_EQ(one.position[i], rest.position[i]);
    EXPECT_EQ(one.rotation[i], rest.rotation[i]);
    EXPECT_EQ(one.log_scale[i], rest.log_scale[i]);
    EXPECT_TRUE(std::equal(rest.sh_of(i), rest.sh_of(i) + 48, one.sh_of(i)));
  }
  EXPECT_GT(still, 100);
  EXPECT_LT(still, 4900);
}

TEST(Deform, CollapsedAndInvertedGradientsStayFinite) {
  const GaussianCloud rest = random_small_cloud(200, 1, 11);
  const std::vector<Vec3f> drivers = lattice(6, 0.2f);
  for (const Mat3f& A :
       {Mat3f(Mat3f::Zero()), Mat3f(-Mat3f::Identity()), Mat3f(1e6f * Mat3f::Identity()), Mat3f(Mat3f::Ones())}) {
    GaussianCloud out;
    deform({}, rest, pliant::bind({}, rest.position, drivers), drivers, moved_points(drivers, A, Vec3f::Zero()),
           std::vector<Mat3f>(drivers.size(), A), out);
    for (size_t i = 0; i < rest.size(); ++i) {
      EXPECT_TRUE(out.position[i].allFinite() && out.rotation[i].allFinite() && out.log_scale[i].allFinite());
      EXPECT_LE(out.log_scale[i].maxCoeff(), rest.log_scale[i].maxCoeff() + std::log(4.01f));
      EXPECT_GE(out.log_scale[i].minCoeff(), rest.log_scale[i].minCoeff() - std::log(4.01f));
    }
  }
}

}  // namespace
}  // namespace pliant
