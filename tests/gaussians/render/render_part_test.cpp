// A part of a picture, drawn by itself within the frame of the whole, is that part of the whole: pictures, blend
// weights and derivatives, also of Gaussians whose Jacobian is held at the border of the frustum.

#include <gtest/gtest.h>

#include <algorithm>

#include "gaussians/render/blend_weights.h"
#include "gaussians/render/picture_frame.h"
#include "gaussians/render/render_as.h"
#include "tests/gaussians/cloud_cast.h"
#include "tests/gaussians/render/random_gaussians.h"

namespace pliant {
namespace {

constexpr int kX = 37, kY = 5, kWidth = 42, kHeight = 33, kFeatures = 2;

/// A wide view from the origin along z, its principal point off the middle, of large Gaussians that reach far beyond
/// the borders of the part.
struct WideScene {
  GaussianCloud single;
  CloudOf<double> cloud;
  std::vector<double> features;
  Camera whole;
  PicturePart part;

  WideScene() {
    single = fixture::random_cloud(
        400, 1, 31, {.half_width = 2.5, .min_log_scale = std::log(0.02), .max_log_scale = std::log(0.5)});
    for (Vec3f& x : single.position) x.z() = 2.3f + 0.5f * x.z();
    cloud = cloud_cast<double>(single);
    for (size_t k = 0; k < cloud.size() * kFeatures; ++k) features.push_back(Random(3, k).uniform(-1, 1));
    whole.width = 96;
    whole.height = 80;
    whole.fx = 56;
    whole.fy = 60;
    whole.cx = 44.5;
    whole.cy = 42.25;
    part = cropped(whole, kX, kY, kWidth, kHeight);
  }
  RenderOptions options(const std::optional<PictureFrame>& frame) const {
    RenderOptions o;
    o.background = Vec3f(0.25f, 0.5f, 1.0f);
    o.antialiased = true;
    return o.within(frame);
  }
  template <bool kCutOffs = true>
  Rendered<double> drawn(const Camera& camera, const std::optional<PictureFrame>& frame,
                         RenderTape<double>* tape = nullptr) const {
    return render_as<double, kCutOffs>(cloud, camera, options(frame), features, kFeatures, tape);
  }
};

double worst_difference(const Image<double>& whole, const Image<double>& part) {
  double worst = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < part.channels; ++c)
        worst = std::max(worst, std::abs(whole(kX + x, kY + y, c) - part(x, y, c)));
  return worst;
}

TEST(RenderPart, IsThatPartOfTheWholePicture) {
  const WideScene scene;
  const Rendered<double> whole = scene.drawn(scene.whole, {}), part = scene.drawn(scene.part.camera, scene.part.frame);
  EXPECT_LT(worst_difference(whole.color, part.color), 1e-9);
  EXPECT_LT(worst_difference(whole.depth, part.depth), 1e-9);
  EXPECT_LT(worst_difference(whole.alpha, part.alpha), 1e-9);
  EXPECT_LT(worst_difference(whole.features, part.features), 1e-9);
  // What the frame is for.
  EXPECT_GT(worst_difference(whole.color, scene.drawn(scene.part.camera, {}).color), 0.01);
}

TEST(RenderPart, TheWholePictureIsAPartOfItselfBitForBit) {
  const WideScene scene;
  const PicturePart all = cropped(scene.whole, 0, 0, scene.whole.width, scene.whole.height);
  EXPECT_EQ(scene.drawn(all.camera, all.frame).color.data, scene.drawn(scene.whole, {}).color.data);
}

TEST(RenderPart, BlendWeightsAreThoseOfThePicture) {
  const WideScene scene;
  const RenderOptions options = scene.options(scene.part.frame);
  const ImageF alpha = render(scene.single, scene.part.camera, options).alpha;
  const BlendWeights weights = blend_weights(scene.single, scene.part.camera, options);
  ASSERT_EQ(weights.pixels(), alpha.data.size());
  for (size_t pixel = 0; pixel < weights.pixels(); ++pixel) {
    double sum = 0;
    for (uint32_t e = weights.row_start[pixel]; e < weights.row_start[pixel + 1]; ++e) sum += weights.weight[e];
    EXPECT_NEAR(sum, alpha.data[pixel], 1e-5);
  }
}

/// All derivatives of a scalar whose derivatives by the pixels of the part are random, and 0 outside.
std::vector<double> derivatives(const WideScene& scene, bool by_part, bool with_tape) {
  const Camera& camera = by_part ? scene.part.camera : scene.whole;
  const std::optional<PictureFrame> frame = by_part ? std::optional(scene.part.frame) : std::nullopt;
  RenderTape<double> tape;
  const Rendered<double> picture = scene.drawn<false>(camera, frame, &tape);
  Rendered<double> adj = picture;
  uint64_t number = 0;
  for (Image<double>* image : {&adj.color, &adj.depth, &adj.alpha, &adj.features}) {
    image->data.assign(image->data.size(), 0.0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < image->channels; ++c)
          (*image)(x + (by_part ? 0 : kX), y + (by_part ? 0 : kY), c) = Random(8, number++).normal();
  }
  const RenderGradient<double> g =
      render_adjoint_as<double, false>(scene.cloud, camera, scene.options(frame), scene.features, kFeatures, picture,
                                       adj, with_tape ? &tape : nullptr, {.covariance = true, .screen = true});
  std::vector<double> out = g.features;
  const auto append = [&](const auto& v) { out.insert(out.end(), v.data(), v.data() + v.size()); };
  for (size_t i = 0; i < g.cloud.size(); ++i) {
    append(g.cloud.position[i]);
    append(g.cloud.rotation[i]);
    append(g.cloud.log_scale[i]);
    append(g.covariance[i]);
    append(g.screen[i]);
  }
  append(g.cloud.opacity_logit);
  append(g.cloud.sh);
  append(g.background);
  append(g.rotation);
  append(g.translation);
  return out;
}

TEST(RenderPart, DerivativesAreThoseOfTheWholePicture) {
  const WideScene scene;
  const std::vector<double> whole = derivatives(scene, false, true);
  double size = 0;
  for (const double g : whole) size = std::max(size, std::abs(g));
  ASSERT_GT(size, 0);
  for (const bool with_tape : {true, false}) {
    const std::vector<double> part = derivatives(scene, true, with_tape);
    ASSERT_EQ(part.size(), whole.size());
    for (size_t k = 0; k < part.size(); ++k) EXPECT_NEAR(part[k], whole[k], 1e-9 * size) << k;
  }
}

}  // namespace
}  // namespace pliant
