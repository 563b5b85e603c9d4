// A window shows what the whole picture shows there.

#include "segmentation/select/window_view.h"

#include <gtest/gtest.h>

#include "gaussians/render/blend_weights.h"
#include "tests/gaussians/render/random_gaussians.h"

namespace pliant {
namespace {

TEST(WindowView, GaussiansWeighInAWindowWhatTheyWeighThereInTheWholePicture) {
  // Large Gaussians seen with a wide angle, so that many reach into the window from far outside.
  GaussianCloud cloud = fixture::random_cloud(
      300, 0, 17, {.half_width = 2.5, .min_log_scale = std::log(0.02), .max_log_scale = std::log(0.4)});
  for (Vec3f& x : cloud.position) x.z() = 2.3f + 0.5f * x.z();
  Camera camera;
  camera.width = 100;
  camera.height = 80;
  camera.fx = camera.fy = 60;
  camera.cx = 47;
  camera.cy = 41;
  const PictureRect rect{50, 10, 80, 34};
  const WindowView window({camera}, 0, rect, 30);
  ASSERT_EQ(window.camera.width, 30);
  ASSERT_EQ(window.camera.height, 24);

  const BlendWeights all = blend_weights(cloud, camera);
  std::vector<double> expected(cloud.size(), 0.0);
  for (int y = 10; y < 34; ++y)
    for (int x = 50; x < 80; ++x) {
      const size_t pixel = static_cast<size_t>(y) * 100 + x;
      for (uint32_t e = all.row_start[pixel]; e < all.row_start[pixel + 1]; ++e)
        expected[all.gaussian[e]] += all.weight[e];
    }
  const auto worst = [&](const std::optional<PictureFrame>& frame) {
    Lift lift(cloud.size());
    lift.add(cloud, window.camera, RenderOptions{}.within(frame), std::vector<uint8_t>(30 * 24, 1));
    double worst = 0;
    for (size_t p = 0; p < cloud.size(); ++p) worst = std::max(worst, std::abs(lift.total[p] - expected[p]));
    return worst;
  };
  // In pixels; a weight below 1/255 may be there in one and not in the other, by rounding.
  EXPECT_LT(worst(window.frame), 0.05);
  EXPECT_GT(worst({}), 0.5);
}

}  // namespace
}  // namespace pliant
