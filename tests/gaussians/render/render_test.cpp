// The rasteriser against a slow double-precision reference, against closed forms of one and two Gaussians, and its
// laws: independence of threads, pictures as W y, degenerate inputs.

#include "gaussians/render/render.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/base/portable.h"
#include "gaussians/base/random.h"
#include "gaussians/render/blend_weights.h"
#include "gaussians/render/render_as.h"
#include "tests/gaussians/cloud_cast.h"
#include "tests/gaussians/render/random_gaussians.h"
#include "tests/gaussians/render/reference_renderer.h"

namespace pliant {
namespace {

using fixture::random_cloud;

Camera test_camera(int width, int height) {
  return look_at({1.5, -3.2, 1.1}, {0.1, 0, 0}, {0, 0, 1}, width, height, 1.1 * width);
}

GaussianCloud ball(const Vec3f& centre, float scale, float opacity, const Vec3f& color) {
  GaussianCloud cloud;
  cloud.resize(1);
  cloud.position[0] = centre;
  cloud.log_scale[0].setConstant(std::log(scale));
  cloud.opacity_logit[0] = logit(opacity);
  for (int c = 0; c < 3; ++c) cloud.sh[c] = (color[c] - 0.5f) / kSh0;
  return cloud;
}

// A camera at the origin that looks along z.
Camera plain_camera(int width, int height, double focal) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal;
  camera.cx = width / 2.0;
  camera.cy = height / 2.0;
  return camera;
}

struct Comparison {
  double worst = 0;     // away from close calls
  int flips = 0;        // pixels that differ by more than the tolerance, all of them
  int unexplained = 0;  // flips that are no close calls
};

template <class T>
Comparison compare(const Rendered<T>& picture, const ReferencePicture& reference, double tolerance) {
  Comparison out;
  for (int y = 0; y < picture.color.height; ++y) {
    for (int x = 0; x < picture.color.width; ++x) {
      double difference = std::abs(picture.alpha(x, y) - reference.alpha(x, y));
      for (int c = 0; c < 3; ++c)
        difference = std::max(difference, std::abs(picture.color(x, y, c) - reference.color(x, y, c)));
      const double scale = std::max(1.0, reference.depth(x, y));
      difference = std::max(difference, std::abs(picture.depth(x, y) - reference.depth(x, y)) / scale);
      out.flips += difference > tolerance;
      if (reference.close_call(x, y)) continue;
      out.worst = std::max(out.worst, difference);
      out.unexplained += difference > tolerance;
    }
  }
  return out;
}

void expect_agreement(const GaussianCloud& cloud, const Camera& camera, const RenderOptions& options) {
  const ReferencePicture reference = render_slowly(cloud, camera, options.background, options.antialiased);
  const Comparison single = compare(render_as<float>(cloud, camera, options), reference, 2e-4);
  const Comparison twice = compare(render_as<double>(cloud_cast<double>(cloud), camera, options), reference, 1e-9);
  const int pixels = camera.width * camera.height;
  std::printf("float: worst %.2e, flips %d of %d; double: worst %.2e, flips %d\n", single.worst, single.flips, pixels,
              twice.worst, twice.flips);
  EXPECT_LE(single.worst, 2e-4);
  EXPECT_LE(single.flips, 0.0005 * pixels);
  EXPECT_LE(twice.worst, 1e-9);
  EXPECT_LE(twice.flips, 0);
}

TEST(Render, AgreesWithTheSlowReferenceOnASmallDenseCloud) {
  RenderOptions options;
  options.background = Vec3f(0.2f, 0.5f, 0.9f);
  expect_agreement(random_cloud(1200, 3, 21), test_camera(141, 99), options);
}

TEST(Render, AgreesWithTheSlowReferenceOnManySmallGaussians) {
  expect_agreement(random_cloud(4000, 1, 22, {.min_log_scale = std::log(0.004), .max_log_scale = std::log(0.05)}),
                   test_camera(120, 96), {});
}

TEST(Render, AgreesWithTheSlowReferenceAntialiased) {
  RenderOptions options;
  options.antialiased = true;
  expect_agreement(random_cloud(2500, 0, 23, {.min_log_scale = std::log(0.002), .max_log_scale = std::log(0.05)}),
                   test_camera(100, 70), options);
}

TEST(Render, AgreesWithTheSlowReferenceFromInsideTheCloudWithNeedlesAndSheets) {
  const Camera camera = look_at({0.1, 0.2, 0.1}, {0.9, 0.3, 0.2}, {0, 0, 1}, 120, 90, 70);
  expect_agreement(random_cloud(800, 2, 24, {.min_log_scale = std::log(0.0005), .max_log_scale = std::log(0.4)}),
                   camera, {});
}

template <class T>
void expect_closed_form_of_one(double tolerance, double filter = 0.3) {
  const double focal = 100, z = 2, scale = 0.1, opacity = 0.8;
  const Vec3f color(0.9f, 0.3f, 0.6f), background(0.1f, 0.2f, 0.3f);
  const Camera camera = plain_camera(40, 30, focal);
  const GaussianCloud cloud =
      ball({0.05f, -0.03f, static_cast<float>(z)}, static_cast<float>(scale), static_cast<float>(opacity), color);
  RenderOptions options;
  options.background = background;
  options.screen_variance = filter;
  const Rendered<T> picture = render_as<T>(cloud_cast<T>(cloud), camera, options);
  const double u = focal * 0.05f / z + 20, v = focal * -0.03f / z + 15;
  // J = f/z [1 0 -x/z; 0 1 -y/z]; for a ball the covariance is s^2 J J^T plus that of the filter.
  const double s = std::exp(static_cast<double>(cloud.log_scale[0][0])), k = s * s * focal * focal / (z * z);
  const double a = 0.05f / z, b = -0.03f / z;
  const double xx = k * (1 + a * a) + filter, xy = k * a * b, yy = k * (1 + b * b) + filter, det = xx * yy - xy * xy;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const double dx = x + 0.5 - u, dy = y + 0.5 - v;
      const double o = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logit[0])));
      double alpha = o * std::exp(-0.5 * (yy * dx * dx - 2 * xy * dx * dy + xx * dy * dy) / det);
      if (alpha < 1.0 / 255) alpha = 0;
      EXPECT_NEAR(picture.alpha(x, y), alpha, tolerance);
      EXPECT_NEAR(picture.depth(x, y), alpha * z, 2 * tolerance);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(picture.color(x, y, c), alpha * color[c] + (1 - alpha) * background[c], tolerance);
    }
  }
}

TEST(Render, OneGaussianIsItsClosedFormInDouble) { expect_closed_form_of_one<double>(1e-6); }
TEST(Render, OneGaussianIsItsClosedFormWithAnotherFilter) { expect_closed_form_of_one<double>(1e-6, 0.07); }
TEST(Render, OneGaussianIsItsClosedFormInFloat) { expect_closed_form_of_one<float>(5e-5); }

template <class T>
void expect_closed_form_of_two(double tolerance) {
  // Both on the optical axis, which passes through the centre of pixel (7, 7); the farther one is stored first.
  Camera camera = plain_camera(15, 15, 60);
  const Vec3f far_color(0.1f, 0.9f, 0.4f), near_color(0.8f, 0.2f, 0.5f);
  GaussianCloud cloud = ball({0, 0, 3}, 0.2f, 0.9f, far_color);
  cloud.append(ball({0, 0, 1.5f}, 0.1f, 0.6f, near_color));
  const Rendered<T> picture = render_as<T>(cloud_cast<T>(cloud), camera);
  const auto alpha = [&](int i, double z, double dx, double dy) {
    const double s = std::exp(static_cast<double>(cloud.log_scale[i][0])) * 60 / z;
    const double o = 1 / (1 + std::exp(-static_cast<double>(cloud.opacity_logit[i])));
    const double a = o * std::exp(-0.5 * (dx * dx + dy * dy) / (s * s + 0.3));
    return a < 1.0 / 255 ? 0 : a;
  };
  for (int y = 0; y < 15; ++y) {
    for (int x = 0; x < 15; ++x) {
      const double front = alpha(1, 1.5, x - 7, y - 7), back = alpha(0, 3, x - 7, y - 7) * (1 - front);
      EXPECT_NEAR(picture.alpha(x, y), front + back, tolerance);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(picture.color(x, y, c), front * near_color[c] + back * far_color[c], tolerance);
    }
  }
}

TEST(Render, TwoGaussiansAreTheirClosedFormInDouble) { expect_closed_form_of_two<double>(1e-6); }
TEST(Render, TwoGaussiansAreTheirClosedFormInFloat) { expect_closed_form_of_two<float>(5e-5); }

TEST(Render, WithoutCutOffsThePictureIsSmoothAndUncut) {
  const Camera camera = plain_camera(64, 16, 60);
  const GaussianCloud cloud = ball({0, 0, 2}, 0.05f, 0.999f, {1, 1, 1});
  const Rendered<double> cut = render_as<double>(cloud_cast<double>(cloud), camera),
                         uncut = render_as<double, false>(cloud_cast<double>(cloud), camera);
  EXPECT_EQ(cut.alpha(25, 8), 0);
  EXPECT_GT(uncut.alpha(25, 8), 1e-6);
  EXPECT_LT(uncut.alpha(25, 8), 1.0 / 255);
  EXPECT_NEAR(uncut.alpha(30, 7), cut.alpha(30, 7), 1e-12);
}

TEST(Render, AlphaIsCutAtItsLimitAndBlendingEndsBeforeTheLastTransmittance) {
  const Camera camera = plain_camera(15, 15, 60);
  GaussianCloud cloud = ball({0, 0, 1}, 1.0f, 0.9999f, {1, 1, 1});
  EXPECT_NEAR(render(cloud, camera).alpha(7, 7), 0.99, 1e-6);
  // 0.01 after one, 1e-4 after two would not fall below the limit in exact numbers; a third one never counts.
  cloud.append(ball({0, 0, 2}, 2.0f, 0.95f, {1, 1, 1}));
  cloud.append(ball({0, 0, 3}, 3.0f, 0.95f, {1, 1, 1}));
  EXPECT_NEAR(render(cloud, camera).alpha(7, 7), 1 - 0.01 * 0.05, 1e-6);
}

void expect_same_bits(const RenderResult& a, const RenderResult& b) {
  EXPECT_EQ(a.color.data, b.color.data);
  EXPECT_EQ(a.depth.data, b.depth.data);
  EXPECT_EQ(a.alpha.data, b.alpha.data);
  EXPECT_EQ(a.features.data, b.features.data);
}

TEST(Render, IsEqualBitForBitForAnyThreadCount) {
  const GaussianCloud cloud = random_cloud(20000, 3, 25);
  const Camera camera = test_camera(200, 150);
  std::vector<float> features(cloud.size() * 5);
  for (size_t i = 0; i < features.size(); ++i) features[i] = static_cast<float>(Random(26, i).normal());
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const RenderResult one = render(cloud, camera, {}, features, 5);
  const BlendWeights weights = blend_weights(cloud, camera);
  for (int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    expect_same_bits(one, render(cloud, camera, {}, features, 5));
    const BlendWeights again = blend_weights(cloud, camera);
    EXPECT_EQ(weights.row_start, again.row_start);
    EXPECT_EQ(weights.gaussian, again.gaussian);
    EXPECT_EQ(weights.weight, again.weight);
  }
  omp_set_num_threads(before);
}

TEST(BlendWeights, RenderedChannelsAreTheWeightsTimesTheAttributes) {
  for (int channels : {1, 16, 19}) {
    const GaussianCloud cloud = random_cloud(5000, 0, 27);
    const Camera camera = test_camera(150, 101);
    std::vector<float> y(cloud.size() * channels);
    for (size_t i = 0; i < y.size(); ++i) y[i] = static_cast<float>(Random(28, i).normal());
    const RenderResult picture = render(cloud, camera, {}, y, channels);
    const BlendWeights W = blend_weights(cloud, camera);
    ASSERT_EQ(W.row_start.size(), W.pixels() + 1);
    ASSERT_GT(W.weight.size(), W.pixels());
    double worst = 0, worst_alpha = 0;
    for (size_t pixel = 0; pixel < W.pixels(); ++pixel) {
      double total = 0;
      std::vector<double> sum(channels, 0.0);
      for (uint32_t e = W.row_start[pixel]; e < W.row_start[pixel + 1]; ++e) {
        total += W.weight[e];
        for (int c = 0; c < channels; ++c)
          sum[c] += static_cast<double>(W.weight[e]) * y[size_t{W.gaussian[e]} * channels + c];
      }
      worst_alpha = std::max(worst_alpha, std::abs(total - picture.alpha.data[pixel]));
      for (int c = 0; c < channels; ++c)
        worst = std::max(worst, std::abs(sum[c] - picture.features.data[pixel * channels + c]));
    }
    EXPECT_LT(worst, 1e-5);
    EXPECT_LT(worst_alpha, 1e-5);
  }
}

TEST(Render, DegenerateGaussiansLeaveNoTraceOfNaN) {
  const Camera camera = plain_camera(33, 17, 30);
  GaussianCloud cloud = ball({0, 0, 2}, 0.1f, 0.7f, {0.2f, 0.4f, 0.6f});
  const RenderResult alone = render(cloud, camera);
  const float inf = INFINITY, nan = NAN;
  const auto add = [&](auto&& change) {
    GaussianCloud bad = ball({0, 0, 1}, 0.1f, 0.9f, {1, 1, 1});
    change(bad);
    cloud.append(bad);
  };
  add([&](GaussianCloud& g) { g.position[0] = Vec3f(0, 0, -1); });
  add([&](GaussianCloud& g) { g.position[0] = Vec3f(0, 0, 0.1f); });
  add([&](GaussianCloud& g) { g.position[0] = Vec3f(nan, 0, 1); });
  add([&](GaussianCloud& g) { g.position[0] = Vec3f(inf, 0, 1); });
  add([&](GaussianCloud& g) { g.log_scale[0] = Vec3f(60, 60, 60); });
  add([&](GaussianCloud& g) { g.log_scale[0] = Vec3f(nan, 0, 0); });
  add([&](GaussianCloud& g) { g.rotation[0] = Vec4f(nan, 0, 0, 0); });
  add([&](GaussianCloud& g) { g.opacity_logit[0] = nan; });
  add([&](GaussianCloud& g) { g.opacity_logit[0] = -inf; });
  add([&](GaussianCloud& g) { g.sh[1] = nan; });
  expect_same_bits(alone, render(cloud, camera));
}

TEST(Render, HugeGaussiansAndTinyOnesStayFinite) {
  const Camera camera = plain_camera(50, 40, 30);
  GaussianCloud cloud = ball({0, 0, 1}, 1e6f, 0.5f, {1, 0, 0});
  cloud.append(ball({0.3f, 0, 0.21f}, 100.0f, 0.5f, {0, 1, 0}));
  cloud.append(ball({0, 0, 2}, 1e-20f, 0.5f, {0, 0, 1}));
  const RenderResult picture = render(cloud, camera);
  for (float value : picture.color.data) EXPECT_TRUE(std::isfinite(value));
  EXPECT_NEAR(picture.alpha(25, 20), 0.75, 0.15);
}

TEST(Render, ZeroQuaternionMeansNoRotation) {
  const Camera camera = plain_camera(33, 17, 30);
  GaussianCloud cloud = ball({0, 0, 2}, 0.1f, 0.7f, {0.2f, 0.4f, 0.6f});
  cloud.log_scale[0] = Vec3f(-1, -2, -3);
  const RenderResult upright = render(cloud, camera);
  cloud.rotation[0].setZero();
  expect_same_bits(upright, render(cloud, camera));
}

TEST(Render, EmptyCloudAndSinglePixel) {
  RenderOptions options;
  options.background = Vec3f(0.1f, 0.2f, 0.3f);
  const RenderResult empty = render(GaussianCloud(), plain_camera(20, 10, 10), options);
  EXPECT_EQ(empty.color(19, 9, 2), 0.3f);
  EXPECT_EQ(empty.alpha(19, 9), 0.0f);
  EXPECT_EQ(blend_weights(GaussianCloud(), plain_camera(20, 10, 10)).row_start.size(), 201u);
  const RenderResult pixel = render(ball({0, 0, 1}, 0.5f, 0.5f, {1, 1, 1}), plain_camera(1, 1, 1));
  EXPECT_NEAR(pixel.alpha(0, 0), 0.5f, 1e-6f);
}

}  // namespace
}  // namespace pliant
