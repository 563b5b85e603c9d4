// Projection with one Gaussian per lane: its elementary functions against the C library, and that no Gaussian feels its
// neighbours in the other lanes, whatever their values and number.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "gaussians/base/random.h"
#include "gaussians/render/project_input.h"
#include "tests/gaussians/render/random_gaussians.h"

#define PLIANT_ISA project_test
#include "gaussians/simd/pack_math.h"

namespace pliant {
namespace {

using project_test::kLanes;
using FloatPack = project_test::FloatPack;

TEST(PackMath, ExponentialAgreesWithTheCLibrary) {
  double worst = 0;
  for (int i = 0; i < 2'000'000; i += kLanes) {
    FloatPack x;
    for (int k = 0; k < kLanes; ++k) x[k] = -87.0f + 175.7f * static_cast<float>(i + k) / 2e6f;
    const FloatPack y = project_test::exponential(x);
    for (int k = 0; k < kLanes; ++k) worst = std::max(worst, std::abs(y[k] / std::exp(double(x[k])) - 1));
  }
  EXPECT_LT(worst, 2e-7);
  std::printf("worst relative error of exp: %.2g\n", worst);
  const float inf = INFINITY;
  const FloatPack large = project_test::exponential(FloatPack{89.0f, inf, -inf, NAN});
  EXPECT_EQ(large[0], inf);
  EXPECT_EQ(large[1], inf);
  EXPECT_EQ(large[2], 0.0f);
  EXPECT_TRUE(std::isnan(large[3]));
  const FloatPack small = project_test::exponential(FloatPack{0.0f, -0.0f, -100.0f, -1000.0f});
  EXPECT_EQ(small[0], 1.0f);
  EXPECT_EQ(small[1], 1.0f);
  EXPECT_NEAR(small[2], std::exp(-100.0), 2e-45);
  EXPECT_EQ(small[3], 0.0f);
}

TEST(PackMath, LogarithmAgreesWithTheCLibrary) {
  double worst = 0;
  const auto check = [&](const FloatPack& x) {
    const FloatPack y = project_test::logarithm2(x);
    for (int k = 0; k < kLanes; ++k) {
      const double exact = std::log2(double(x[k]));
      worst = std::max(worst, exact == 0 ? std::abs(double(y[k])) : std::abs(y[k] / exact - 1));
    }
  };
  for (int i = 0; i < 1'000'000; i += kLanes) {
    FloatPack near_one, any;
    for (int k = 0; k < kLanes; ++k) {
      near_one[k] = 0.4f + 1.2f * static_cast<float>(i + k) / 1e6f;
      any[k] = static_cast<float>(std::exp2(Random(1, i, k).uniform(-126, 127)));
    }
    check(near_one);
    check(any);
  }
  EXPECT_LT(worst, 2.5e-7);
  std::printf("worst relative error of log2: %.2g\n", worst);
}

Camera front_camera() { return look_at({0.3, -4, 0.4}, {0, 0, 0}, {0, 0, 1}, 120, 90, 130); }

GaussianCloud random_wide_cloud(int n, int degree) {
  return fixture::random_cloud(n, degree, 11,
                               {.half_width = 1,
                                .min_log_scale = -5,
                                .max_log_scale = -1,
                                .min_opacity_logit = -4,
                                .max_opacity_logit = 4,
                                .color = 0.2,
                                .shine = 0.2});
}

class Projection : public testing::TestWithParam<InstructionSet> {
 protected:
  const BlendKernels<float>& kernels() const { return blend_kernels<float, true>(GetParam()); }

  std::vector<Splat<float>> splats(const CloudOf<float>& cloud, size_t begin, size_t end) const {
    std::vector<Splat<float>> out(end - begin);
    out.resize(kernels().project({cloud_input(cloud), make_view<float>(front_camera()), true, begin, end}, out.data()));
    return out;
  }

  // Position, rotation, log scale, opacity, SH and covariance of each Gaussian, row by row.
  std::vector<std::vector<float>> gradients(const CloudOf<float>& cloud, const std::vector<uint32_t>& index,
                                            ViewGradient<float>& view) const {
    std::vector<float> sums;
    for (const uint32_t i : index)
      for (int k = 0; k < kPairSlots; ++k) sums.push_back(static_cast<float>(Random(5, i, k).normal()));
    CloudOf<float> g;
    g.sh_degree = cloud.sh_degree;
    g.resize(cloud.size());
    for (auto& q : g.rotation) q.setZero();
    std::vector<Mat3f> covariance(cloud.size(), Mat3f::Zero());
    kernels().project_adjoint(
        {cloud_input(cloud), make_view<float>(front_camera()), true, index.data(), sums.data(), index.size()},
        cloud_gradient(g, covariance), view);
    std::vector<std::vector<float>> rows(cloud.size());
    for (size_t i = 0; i < cloud.size(); ++i) {
      const auto append = [&](const float* from, int n) { rows[i].insert(rows[i].end(), from, from + n); };
      append(g.position[i].data(), 3);
      append(g.rotation[i].data(), 4);
      append(g.log_scale[i].data(), 3);
      append(&g.opacity_logit[i], 1);
      append(g.sh_of(i), 3 * g.sh_count());
      append(covariance[i].data(), 9);
    }
    return rows;
  }
};

bool same(const Splat<float>& a, const Splat<float>& b) {
  return std::memcmp(&a, &b, offsetof(Splat<float>, last_row) + sizeof a.last_row) == 0;
}

TEST_P(Projection, AnyRangeOfGaussiansGivesTheSameSplats) {
  for (const int degree : {0, 1, 2, 3}) {
    const CloudOf<float> cloud = random_wide_cloud(37, degree);
    const std::vector<Splat<float>> all = splats(cloud, 0, cloud.size());
    ASSERT_GT(all.size(), 25u);
    for (size_t begin = 0; begin < cloud.size(); ++begin) {
      for (const size_t count : {1, 2, 3, 5, 7, 9}) {
        const size_t end = std::min(cloud.size(), begin + count);
        size_t next = 0;
        while (next < all.size() && all[next].index < begin) ++next;
        for (const Splat<float>& s : splats(cloud, begin, end)) {
          ASSERT_LT(next, all.size());
          EXPECT_TRUE(same(s, all[next++]));
        }
        EXPECT_TRUE(next == all.size() || all[next].index >= end);
      }
    }
  }
}

TEST_P(Projection, AbsurdGaussiansAreLeftOutAndDoNotDisturbTheirNeighbours) {
  const CloudOf<float> cloud = random_wide_cloud(64, 1);
  const std::vector<Splat<float>> all = splats(cloud, 0, cloud.size());
  const float inf = INFINITY, nan = NAN;
  const std::vector<std::function<void(CloudOf<float>&, size_t)>> absurd = {
      [&](auto& c, size_t i) { c.position[i][1] = nan; },
      [&](auto& c, size_t i) { c.position[i][0] = inf; },
      [&](auto& c, size_t i) { c.position[i] = Vec3f(0.3f, -4, 0.4f); },
      [&](auto& c, size_t i) { c.log_scale[i].setConstant(69); },
      [&](auto& c, size_t i) { c.log_scale[i][2] = nan; },
      [&](auto& c, size_t i) { c.rotation[i][3] = nan; },
      [&](auto& c, size_t i) { c.opacity_logit[i] = -inf; },
      [&](auto& c, size_t i) { c.opacity_logit[i] = nan; },
      [&](auto& c, size_t i) { c.sh_of(i)[4] = nan; },
  };
  for (size_t kind = 0; kind < absurd.size(); ++kind) {
    CloudOf<float> changed = cloud;
    for (size_t i = kind; i < cloud.size(); i += 5) absurd[kind](changed, i);
    std::vector<Splat<float>> expected;
    for (const Splat<float>& s : all)
      if (s.index < kind || (s.index - kind) % 5 != 0) expected.push_back(s);
    const std::vector<Splat<float>> found = splats(changed, 0, cloud.size());
    ASSERT_EQ(found.size(), expected.size()) << kind;
    for (size_t k = 0; k < found.size(); ++k) EXPECT_TRUE(same(found[k], expected[k])) << kind;
  }
}

TEST_P(Projection, ZeroQuaternionMeansNoRotationAndInfiniteLogitFullOpacity) {
  CloudOf<float> cloud = random_wide_cloud(9, 0), upright = cloud;
  for (const size_t i : {2, 4, 7}) {
    cloud.rotation[i].setZero();
    upright.rotation[i] = Vec4f(1, 0, 0, 0);
    cloud.opacity_logit[i] = INFINITY;
    upright.opacity_logit[i] = 100;
  }
  const std::vector<Splat<float>> a = splats(cloud, 0, 9), b = splats(upright, 0, 9);
  ASSERT_EQ(a.size(), b.size());
  for (size_t k = 0; k < a.size(); ++k) EXPECT_TRUE(same(a[k], b[k]));
}

TEST_P(Projection, OpacityAgreesWithTheCLibrary) {
  CloudOf<float> cloud;
  cloud.resize(4000);
  for (size_t i = 0; i < cloud.size(); ++i) {
    cloud.log_scale[i].setConstant(-2);
    cloud.opacity_logit[i] = -5.5f + 0.003f * static_cast<float>(i);
  }
  std::vector<Splat<float>> out(cloud.size());
  out.resize(
      kernels().project({cloud_input(cloud), make_view<float>(front_camera()), false, 0, cloud.size()}, out.data()));
  ASSERT_GT(out.size(), 3900u);
  for (const Splat<float>& s : out)
    EXPECT_NEAR(s.log2_opacity, -std::log1p(std::exp(-double(cloud.opacity_logit[s.index]))) / std::log(2.0), 1e-6);
}

TEST_P(Projection, DerivativesOfAGaussianDoNotDependOnItsNeighbours) {
  for (const int degree : {0, 3}) {
    const CloudOf<float> cloud = random_wide_cloud(29, degree);
    std::vector<uint32_t> everyone, some;
    for (const Splat<float>& s : splats(cloud, 0, cloud.size())) {
      everyone.push_back(s.index);
      if (s.index % 3 != 1) some.push_back(s.index);
    }
    ViewGradient<float> view_of_all, view_of_some, view_one_by_one;
    const auto all = gradients(cloud, everyone, view_of_all), part = gradients(cloud, some, view_of_some);
    for (const uint32_t i : everyone) {
      const auto alone = gradients(cloud, {i}, view_one_by_one);
      EXPECT_EQ(all[i], alone[i]);
      EXPECT_EQ(part[i], i % 3 != 1 ? all[i] : std::vector<float>(part[i].size(), 0.0f));
    }
    double size = 0, difference = 0;
    for (int k = 0; k < 15; ++k) {
      const double a = reinterpret_cast<const float*>(&view_of_all)[k];
      difference += std::pow(a - reinterpret_cast<const float*>(&view_one_by_one)[k], 2);
      size += a * a;
    }
    EXPECT_LT(std::sqrt(difference), 1e-5 * std::sqrt(size));
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, Projection,
                         testing::ValuesIn(best_instruction_set() == InstructionSet::kBaseline
                                               ? std::vector{InstructionSet::kBaseline}
                                               : std::vector{InstructionSet::kBaseline, best_instruction_set()}));

}  // namespace
}  // namespace pliant
