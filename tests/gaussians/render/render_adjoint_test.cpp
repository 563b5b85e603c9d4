// Derivatives of the rasteriser against finite differences in double, without the cut-offs that make the picture jump;
// what the cut-offs change; and the laws of the float version: equal bits for any thread count, independence of bands.

#include <gtest/gtest.h>

#include "gaussians/base/portable.h"
#include "gaussians/render/project_input.h"
#include "gaussians/render/render_as.h"
#include "gaussians/render/splat_kernels.h"
#include "tests/check_adjoint.h"
#include "tests/gaussians/cloud_cast.h"

namespace pliant {
namespace {

using Values = std::vector<double>;
constexpr double kTolerance = 1e-6;
constexpr int kChannels = 2;

Camera adjoint_camera(int width, int height) {
  return look_at({0.4, -4.1, 0.7}, {0.1, 0, 0.05}, {0, 0, 1}, width, height, 1.1 * width);
}

// Depths are spread evenly: a small step then never changes their order, where the picture jumps.
CloudOf<double> spread_cloud(int n, int degree, double smallest, double largest) {
  const Camera camera = adjoint_camera(16, 16);
  CloudOf<double> cloud;
  cloud.sh_degree = degree;
  cloud.resize(n);
  for (int i = 0; i < n; ++i) {
    Random random(7, i);
    const Vec3d in_camera(random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2),
                          4.1 + 2.4 * ((i * 7919 % n + random.uniform(0.3, 0.7)) / n - 0.5));
    cloud.position[i] = camera.cam_from_world.inverse() * in_camera;
    for (int k = 0; k < 3; ++k) cloud.log_scale[i][k] = random.uniform(std::log(smallest), std::log(largest));
    for (int k = 0; k < 4; ++k) cloud.rotation[i][k] = random.normal();
    cloud.opacity_logit[i] = random.uniform(-3, 1);
    for (int k = 0; k < cloud.sh_count() * 3; ++k) cloud.sh_of(i)[k] = random.normal() * (k < 3 ? 0.5 : 0.1);
  }
  return cloud;
}

// All that a picture depends on as one vector: cloud, features, and a small motion of the camera.
struct Inputs {
  CloudOf<double> cloud;
  Values features;
  Vec3d rotation = Vec3d::Zero(), translation = Vec3d::Zero();

  template <class Visit>
  void for_each(Visit&& visit) {
    for (size_t i = 0; i < cloud.size(); ++i) {
      for (int k = 0; k < 3; ++k) visit(cloud.position[i][k]);
      for (int k = 0; k < 4; ++k) visit(cloud.rotation[i][k]);
      for (int k = 0; k < 3; ++k) visit(cloud.log_scale[i][k]);
      visit(cloud.opacity_logit[i]);
    }
    for (double& x : cloud.sh) visit(x);
    for (double& x : features) visit(x);
    for (int k = 0; k < 3; ++k) {
      visit(rotation[k]);
      visit(translation[k]);
    }
  }
  Values packed() {
    Values x;
    for_each([&](double& value) { x.push_back(value); });
    return x;
  }
  Inputs unpacked(const Values& x) const {
    Inputs out = *this;
    size_t at = 0;
    out.for_each([&](double& value) { value = x[at++]; });
    return out;
  }
};

Camera moved(const Camera& camera, const Vec3d& rotation, const Vec3d& translation) {
  Camera out = camera;
  const double angle = rotation.norm();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (angle > 0) motion.linear() = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  motion.translation() = translation;
  out.cam_from_world = motion * camera.cam_from_world;
  return out;
}

Inputs inputs_of(CloudOf<double> cloud) {
  Inputs in{std::move(cloud), {}};
  for (size_t k = 0; k < in.cloud.size() * kChannels; ++k) in.features.push_back(Random(3, k).uniform(-1, 1));
  return in;
}

Values flattened(const Rendered<double>& picture) {
  Values y;
  for (const auto* image : {&picture.color, &picture.depth, &picture.alpha, &picture.features})
    y.insert(y.end(), image->data.begin(), image->data.end());
  return y;
}

// Inverse of `flattened`, with the shapes of `like`.
Rendered<double> unflattened(const Values& y, Rendered<double> like) {
  size_t at = 0;
  for (auto* image : {&like.color, &like.depth, &like.alpha, &like.features})
    for (double& value : image->data) value = y[at++];
  return like;
}

template <bool kCutOffs>
AdjointCheck check_picture(Inputs inputs, const Camera& camera, bool antialiased, const AdjointCheckOptions& check,
                           size_t spoiled = SIZE_MAX, double filter = splat::kScreenVariance) {
  RenderOptions options;
  options.background = Vec3f(0.25f, 0.5f, 1.0f);
  options.antialiased = antialiased;
  options.screen_variance = filter;
  const auto f = [&](const Values& x) {
    const Inputs in = inputs.unpacked(x);
    return flattened(render_as<double, kCutOffs>(in.cloud, moved(camera, in.rotation, in.translation), options,
                                                 in.features, kChannels));
  };
  const auto adjoint = [&](const Values& x, const Values& adj_y) {
    Inputs in = inputs.unpacked(x);
    const Camera now = moved(camera, in.rotation, in.translation);
    RenderTape<double> tape;
    const Rendered<double> picture = render_as<double, kCutOffs>(in.cloud, now, options, in.features, kChannels, &tape);
    const RenderGradient<double> gradient = render_adjoint_as<double, kCutOffs>(
        in.cloud, now, options, in.features, kChannels, picture, unflattened(adj_y, picture), &tape);
    Values out = Inputs{gradient.cloud, gradient.features, gradient.rotation, gradient.translation}.packed();
    if (spoiled < out.size()) out[spoiled] *= 1 + 1e-4;
    return out;
  };
  return check_adjoint(f, adjoint, inputs.packed(), check);
}

TEST(RenderAdjoint, EveryPixelOfAFewGaussiansAgreesWithFiniteDifferences) {
  for (const bool antialiased : {false, true}) {
    AdjointCheckOptions check;
    check.step = 1e-3;
    const AdjointCheck result =
        check_picture<false>(inputs_of(spread_cloud(5, 3, 0.2, 0.7)), adjoint_camera(9, 8), antialiased, check);
    EXPECT_LT(result.worst, kTolerance) << result.message;
    std::printf("%s\n", result.message.c_str());
  }
}

TEST(RenderAdjoint, AnotherFilterAgreesWithFiniteDifferences) {
  AdjointCheckOptions check;
  check.step = 1e-3;
  check.unit_cotangents = 4;
  const AdjointCheck result =
      check_picture<false>(inputs_of(spread_cloud(5, 3, 0.2, 0.7)), adjoint_camera(9, 8), true, check, SIZE_MAX, 0.07);
  EXPECT_LT(result.worst, kTolerance) << result.message;
}

TEST(RenderAdjoint, OneWrongEntryIsNoticed) {
  Inputs inputs = inputs_of(spread_cloud(5, 3, 0.2, 0.7));
  AdjointCheckOptions check;
  check.step = 1e-3;
  check.unit_cotangents = 4;
  for (const size_t entry : {0, 25, 54}) {
    const AdjointCheck result = check_picture<false>(inputs, adjoint_camera(9, 8), false, check, entry);
    EXPECT_GT(result.worst, 5 * kTolerance) << entry;
  }
}

TEST(RenderAdjoint, PictureOfFiveHundredGaussiansAgreesWithFiniteDifferences) {
  AdjointCheckOptions check;
  check.step = 3e-4;
  check.unit_cotangents = 3;
  check.random_cotangents = 3;
  check.inputs = 60;
  check.random_directions = 4;
  const AdjointCheck result =
      check_picture<false>(inputs_of(spread_cloud(500, 1, 0.03, 0.3)), adjoint_camera(20, 18), false, check);
  EXPECT_LT(result.worst, kTolerance) << result.message;
  std::printf("%s\n", result.message.c_str());
}

TEST(RenderAdjoint, GaussiansOutsideTheFrustumWhoseJacobianIsHeldAgreeWithFiniteDifferences) {
  Inputs inputs = inputs_of(spread_cloud(3, 0, 0.5, 1.5));
  const Camera camera = adjoint_camera(9, 8);
  inputs.cloud.position[0] = camera.cam_from_world.inverse() * Vec3d(3.6, 0.3, 4.5);
  inputs.cloud.position[1] = camera.cam_from_world.inverse() * Vec3d(-0.2, -3.5, 4.1);
  inputs.cloud.position[2] = camera.cam_from_world.inverse() * Vec3d(-3.8, 3.7, 3.9);
  AdjointCheckOptions check;
  check.step = 1e-3;
  const AdjointCheck result = check_picture<false>(inputs, camera, true, check);
  std::printf("%s\n", result.message.c_str());
  EXPECT_LT(result.worst, kTolerance) << result.message;
}

TEST(RenderAdjoint, CovarianceCarriesTheSameDerivativeAsItsFactor) {
  const CloudOf<double> cloud = spread_cloud(43, 0, 0.03, 0.4);
  std::vector<uint32_t> index(cloud.size());
  std::vector<double> sums;
  for (uint32_t i = 0; i < cloud.size(); ++i) {
    index[i] = i;
    for (int k = 0; k < kPairSlots; ++k) sums.push_back(Random(5, i, k).normal());
  }
  CloudOf<double> g;
  g.resize(cloud.size());
  for (auto& q : g.rotation) q.setZero();
  std::vector<Mat3d> covariance(cloud.size(), Mat3d::Zero());
  ViewGradient<double> view;
  blend_kernels<double, false>(best_instruction_set())
      .project_adjoint({cloud_input(cloud), make_view<double>(adjoint_camera(64, 48)), true, index.data(), sums.data(),
                        cloud.size()},
                       cloud_gradient(g, covariance), view);
  for (uint32_t i = 0; i < cloud.size(); ++i) {
    const Mat3d A = covariance_factor<double>(cloud.rotation[i], cloud.log_scale[i]);
    // Sigma = A A^T, so that dL/dA = 2 dL/dSigma A.
    Vec3d log_scale;
    Eigen::Vector4d rotation;
    covariance_factor_adjoint<double>(cloud.rotation[i], cloud.log_scale[i], A, 2 * covariance[i] * A, rotation,
                                      log_scale);
    EXPECT_LT((log_scale - g.log_scale[i]).norm(), 1e-10 * (1 + log_scale.norm()));
    EXPECT_LT((rotation - g.rotation[i]).norm(), 1e-10 * (1 + rotation.norm()));
    EXPECT_LT((covariance[i] - covariance[i].transpose()).norm(), 1e-12 * (1 + covariance[i].norm()));
    EXPECT_GT(g.log_scale[i].norm(), 0);
  }
}

TEST(RenderAdjoint, BackgroundGetsWhatTheTransmittanceLeaves) {
  const CloudOf<double> cloud = spread_cloud(30, 0, 0.1, 0.4);
  const Camera camera = adjoint_camera(20, 20);
  const Rendered<double> picture = render_as<double, false>(cloud, camera);
  Rendered<double> adj;
  adj.color = Image<double>(20, 20, 3);
  Vec3d expected = Vec3d::Zero();
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x)
      for (int c = 0; c < 3; ++c) {
        adj.color(x, y, c) = Random(9, y * 20 + x, c).normal();
        expected[c] += adj.color(x, y, c) * (1 - picture.alpha(x, y));
      }
  const auto gradient = render_adjoint_as<double, false>(cloud, camera, {}, {}, 0, picture, adj);
  EXPECT_LT((gradient.background - expected).norm(), 1e-12 * expected.norm());
}

// A made scene in float with derivatives of everything, for the laws of the float version.
struct FloatScene {
  CloudOf<float> cloud = cloud_cast<float>(spread_cloud(3000, 2, 0.02, 0.2));
  Camera camera = adjoint_camera(150, 110);
  std::vector<float> features;
  RenderResult adj;

  FloatScene() {
    for (size_t k = 0; k < cloud.size() * kChannels; ++k)
      features.push_back(static_cast<float>(Random(3, k).uniform(-1, 1)));
    const auto noise = [&](int channels) {
      ImageF image(camera.width, camera.height, channels);
      for (size_t k = 0; k < image.data.size(); ++k) image.data[k] = static_cast<float>(Random(channels, k).normal());
      return image;
    };
    adj = {noise(3), noise(1), noise(1), noise(kChannels)};
  }
  RenderGradient<float> gradient(const RenderOptions& options = {}) const {
    RenderTape<float> tape;
    const RenderResult picture = render(cloud, camera, options, features, kChannels, &tape);
    return render_adjoint(cloud, camera, options, features, kChannels, picture, adj, &tape,
                          {.covariance = true, .screen = true});
  }
};

std::vector<float> all_of(const RenderGradient<float>& g) {
  std::vector<float> out = g.cloud.opacity_logit;
  for (size_t i = 0; i < g.cloud.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      out.push_back(g.cloud.position[i][k]);
      out.push_back(g.cloud.log_scale[i][k]);
    }
    for (int k = 0; k < 4; ++k) out.push_back(g.cloud.rotation[i][k]);
    for (int k = 0; k < 9; ++k) out.push_back(g.covariance[i](k / 3, k % 3));
  }
  for (const Vec2f& v : g.screen) out.insert(out.end(), v.data(), v.data() + 2);
  out.insert(out.end(), g.cloud.sh.begin(), g.cloud.sh.end());
  out.insert(out.end(), g.features.begin(), g.features.end());
  for (const Vec3f& v : {g.background, g.rotation, g.translation}) out.insert(out.end(), v.data(), v.data() + 3);
  return out;
}

double relative_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double difference = 0, size = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    difference += std::pow(double(a[k]) - b[k], 2);
    size += std::pow(double(b[k]), 2);
  }
  return std::sqrt(difference / size);
}

TEST(RenderAdjoint, ScreenGradientsSumUpToThatOfThePrincipalPoint) {
  const CloudOf<double> cloud = spread_cloud(20, 1, 0.05, 0.4);
  const Camera camera = adjoint_camera(40, 32);
  Rendered<double> adj;
  adj.color = Image<double>(camera.width, camera.height, 3);
  for (size_t k = 0; k < adj.color.data.size(); ++k) adj.color.data[k] = Random(5, k).normal();
  const auto value = [&](double cx, double cy) {
    Camera shifted = camera;
    shifted.cx += cx;
    shifted.cy += cy;
    const Rendered<double> picture = render_as<double, false>(cloud, shifted);
    double sum = 0;
    for (size_t k = 0; k < adj.color.data.size(); ++k) sum += adj.color.data[k] * picture.color.data[k];
    return sum;
  };
  const Rendered<double> picture = render_as<double, false>(cloud, camera);
  const RenderGradient<double> g =
      render_adjoint_as<double, false>(cloud, camera, {}, {}, 0, picture, adj, nullptr, {.screen = true});
  ASSERT_EQ(g.screen.size(), cloud.size());
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& of_one : g.screen) sum += of_one;
  const double h = 1e-4;
  EXPECT_NEAR(sum.x(), (value(h, 0) - value(-h, 0)) / (2 * h), 1e-6 * sum.norm());
  EXPECT_NEAR(sum.y(), (value(0, h) - value(0, -h)) / (2 * h), 1e-6 * sum.norm());
}

TEST(RenderAdjoint, IsEqualBitForBitForAnyThreadCount) {
  const FloatScene scene;
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const std::vector<float> one = all_of(scene.gradient());
  for (const float g : one) ASSERT_TRUE(std::isfinite(g));
  for (const int threads : {2, 3, 4}) {
    omp_set_num_threads(threads);
    EXPECT_EQ(one, all_of(scene.gradient())) << threads;
  }
  omp_set_num_threads(before);
}

TEST(RenderAdjoint, BandsChangeNothingButTheOrderOfSums) {
  const FloatScene scene;
  RenderOptions bands;
  bands.most_pairs = 2000;
  EXPECT_GT((project_splats<float, true>(scene.cloud, scene.camera, false, bands.most_pairs).bands.size()), 5u);
  EXPECT_EQ(render(scene.cloud, scene.camera, bands).color.data, render(scene.cloud, scene.camera).color.data);
  EXPECT_LT(relative_difference(all_of(scene.gradient(bands)), all_of(scene.gradient())), 1e-6);
}

TEST(RenderAdjoint, InstructionSetsAgreeToRounding) {
  if (best_instruction_set() == InstructionSet::kBaseline) GTEST_SKIP() << "this processor has no AVX2";
  const FloatScene scene;
  RenderOptions baseline;
  baseline.instruction_set = InstructionSet::kBaseline;
  const RenderResult a = render(scene.cloud, scene.camera), b = render(scene.cloud, scene.camera, baseline);
  EXPECT_LT(relative_difference(a.color.data, b.color.data), 1e-6);
  EXPECT_LT(relative_difference(all_of(scene.gradient()), all_of(scene.gradient(baseline))), 1e-4);
}

TEST(RenderAdjoint, FloatFollowsDouble) {
  const FloatScene scene;
  const CloudOf<double> cloud = cloud_cast<double>(scene.cloud);
  const std::vector<double> features(scene.features.begin(), scene.features.end());
  const Rendered<double> picture = render_as<double>(cloud, scene.camera, {}, features, kChannels);
  Rendered<double> adj = picture;
  const auto copy = [](const ImageF& from, Image<double>& to) { to.data.assign(from.data.begin(), from.data.end()); };
  copy(scene.adj.color, adj.color);
  copy(scene.adj.depth, adj.depth);
  copy(scene.adj.alpha, adj.alpha);
  copy(scene.adj.features, adj.features);
  const auto exact = render_adjoint_as<double>(cloud, scene.camera, {}, features, kChannels, picture, adj);
  const RenderGradient<float> single = scene.gradient();
  const auto compare = [&](const auto& a, const auto& b) {
    double difference = 0, size = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      difference += (a[i].template cast<double>() - b[i]).squaredNorm();
      size += b[i].squaredNorm();
    }
    return std::sqrt(difference / size);
  };
  EXPECT_LT(compare(single.cloud.position, exact.cloud.position), 1e-3);
  EXPECT_LT(compare(single.cloud.rotation, exact.cloud.rotation), 1e-3);
  EXPECT_LT(compare(single.cloud.log_scale, exact.cloud.log_scale), 1e-3);
}

// The derivative with cut-offs leaves out how their borders move.  This is the error that remains, per parameter kind,
// against the smooth picture.
TEST(RenderAdjoint, BiasOfTheCutOffsIsSmall) {
  const CloudOf<double> cloud = spread_cloud(500, 1, 0.03, 0.3);
  const Camera camera = adjoint_camera(60, 45);
  const auto gradient = [&]<bool kCutOffs>() {
    const Rendered<double> picture = render_as<double, kCutOffs>(cloud, camera);
    Rendered<double> adj;
    adj.color = Image<double>(60, 45, 3);
    for (size_t k = 0; k < adj.color.data.size(); ++k) adj.color.data[k] = picture.color.data[k] - 0.5;
    return render_adjoint_as<double, kCutOffs>(cloud, camera, {}, {}, 0, picture, adj).cloud;
  };
  const CloudOf<double> cut = gradient.template operator()<true>(), smooth = gradient.template operator()<false>();
  const auto bias = [&](auto&& part) {
    double difference = 0, size = 0;
    for (size_t i = 0; i < cloud.size(); ++i) {
      difference += (part(cut, i) - part(smooth, i)).squaredNorm();
      size += part(smooth, i).squaredNorm();
    }
    return std::sqrt(difference / size);
  };
  const double position = bias([](const auto& c, size_t i) { return c.position[i]; });
  const double log_scale = bias([](const auto& c, size_t i) { return c.log_scale[i]; });
  const double opacity = bias([](const auto& c, size_t i) { return Vec3d(c.opacity_logit[i], 0, 0); });
  std::printf("bias of the cut-offs: position %.2g, log scale %.2g, opacity %.2g\n", position, log_scale, opacity);
  EXPECT_LT(position, 0.05);
  EXPECT_LT(log_scale, 0.05);
  EXPECT_LT(opacity, 0.05);
}

}  // namespace
}  // namespace pliant
