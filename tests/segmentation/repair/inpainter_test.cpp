// Repair with an inpainter: it paints the view with the largest hole, depth carries that to the other views.

#include "segmentation/model_interfaces/inpainter.h"

#include <gtest/gtest.h>

#include <numeric>

#include "segmentation/repair/repair.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

/// Paints a ramp over the picture, with the number of the call as its blue.
class RampPainter : public Inpainter {
 public:
  ImageF inpaint(const ImageF& picture, const ImageU8& mask) override {
    ImageF out = picture;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if (mask(x, y))
          for (int k = 0; k < 3; ++k)
            out(x, y, k) = ramp(x + 0.5f, y + 0.5f, static_cast<int>(masks.size()), mask.width, mask.height)[k];
    for (const float value : picture.data) in_range = in_range && value >= 0 && value <= 1;
    masks.push_back(mask);
    return out;
  }
  static Vec3f ramp(float x, float y, int call, int width, int height) {
    return {x / static_cast<float>(width), y / static_cast<float>(height),
            std::max(0.0f, 0.9f - 0.4f * static_cast<float>(call))};
  }
  size_t painted(size_t call) const {
    return std::accumulate(masks[call].data.begin(), masks[call].data.end(), size_t(0));
  }

  std::vector<ImageU8> masks;
  bool in_range = true;
};

struct Painted {
  GaussianCloud background, object;
  std::vector<Camera> cameras;
  RampPainter painter;
  RepairResult result;
};
Painted painted(int max_planes, int refine_rounds) {
  const MadeScene scene = made_scene(two_balls(), 8, 160, 120);
  std::vector<int> object, background;
  for (size_t p = 0; p < scene.truth.size(); ++p)
    (scene.truth[p] == 300 ? object : background).push_back(static_cast<int>(p));
  Painted out{scene.cloud.select(background), scene.cloud.select(object), scene.cameras, {}, {}};
  RepairOptions options;
  options.max_planes = max_planes;
  options.refine.rounds = refine_rounds;
  out.result = repair(options, out.background, out.object, out.cameras, {}, &out.painter);
  return out;
}

/// View with the largest hole.
int reference(const RepairSummary& summary) {
  const auto largest = std::max_element(summary.hole_before.begin(), summary.hole_before.end());
  return summary.views[largest - summary.hole_before.begin()];
}

Vec3f color(const GaussianCloud& cloud, size_t p) {
  return Vec3f(cloud.sh_of(p)[0], cloud.sh_of(p)[1], cloud.sh_of(p)[2]) * kSh0 + Vec3f::Constant(0.5f);
}

TEST(Inpainter, PaintsTheLargestHoleFirstAndWhatItShowsIsNotPaintedAgain) {
  const Painted out = painted(4, 0);
  ASSERT_GE(out.painter.masks.size(), 1u);
  EXPECT_TRUE(out.painter.in_range);
  EXPECT_EQ(out.result.summary.inpainted_views, out.painter.masks.size());
  const RepairSummary& summary = out.result.summary;
  EXPECT_GE(out.painter.painted(0), *std::max_element(summary.hole_before.begin(), summary.hole_before.end()));
  for (size_t call = 1; call < out.painter.masks.size(); ++call)
    EXPECT_LT(out.painter.painted(call), out.painter.painted(0) / 4);
  EXPECT_LT(summary.after(), summary.before() / 50);
  EXPECT_LT(summary.outside_change, 2e-3f);
}

TEST(Inpainter, NewGaussiansCarryTheColourOfThePaintedViewWhereTheyProject) {
  const Painted out = painted(4, 0);
  const Camera& camera = out.cameras[reference(out.result.summary)];
  size_t checked = 0, total = 0;
  for (size_t p = out.result.first_new; p < out.result.background.size(); ++p, ++total) {
    const Vec3d x = camera.cam_from_world * out.result.background.position[p].cast<double>();
    const double u = camera.fx * x.x() / x.z() + camera.cx, v = camera.fy * x.y() / x.z() + camera.cy;
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height ||
        !out.painter.masks[0](static_cast<int>(u), static_cast<int>(v)))
      continue;
    const Vec3f wanted =
        RampPainter::ramp(static_cast<float>(u), static_cast<float>(v), 0, camera.width, camera.height);
    // Beside the mask the ramp is mixed with the picture.
    if ((color(out.result.background, p) - wanted).cwiseAbs().maxCoeff() < 0.01f) ++checked;
    EXPECT_LT(std::abs(out.result.background.position[p].z()), 0.002f);
  }
  EXPECT_GT(checked, 100u);
  EXPECT_GT(static_cast<double>(checked), 0.85 * static_cast<double>(total));
}

TEST(Inpainter, WithoutPlanesThePaintIsPlacedAtTheDepthOfTheSurroundings) {
  const Painted out = painted(0, 0);
  EXPECT_EQ(out.result.summary.plane_gaussians, 0u);
  EXPECT_GT(out.result.summary.view_gaussians, 100u);
  EXPECT_LT(out.result.summary.after(), out.result.summary.before() / 20);
}

TEST(Inpainter, RefinementBringsTheOtherViewsCloserToThePaint) {
  const Painted out = painted(4, 8);
  const RefineSummary& refinement = out.result.summary.refinement;
  ASSERT_TRUE(refinement.kept) << refinement.mse_before << ' ' << refinement.mse_after;
  EXPECT_LT(refinement.mse_after, 0.8 * refinement.mse_before) << refinement.mse_before;
  EXPECT_LT(out.result.summary.after(), out.result.summary.before() / 50);
}

}  // namespace
}  // namespace pliant
