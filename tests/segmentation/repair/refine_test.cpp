// New Gaussians are refined against filled views: the error falls, nothing else moves, threads do not matter.

#include "segmentation/repair/refine.h"

#include <gtest/gtest.h>
#include <omp.h>

#include "gaussians/render/render.h"
#include "tests/segmentation/made_scene.h"

namespace pliant {
namespace {

constexpr float kRadius = 0.22f;  // of the new discs' region

struct Wall {
  GaussianCloud cloud;  ///< fixed discs, then new ones with washed-out colours
  size_t first_new = 0;
  std::vector<FilledView> views;
};

Wall wall() {
  GaussianCloud fixed, fresh, truth;
  for (float x = -0.6f; x <= 0.6f; x += 0.03f)
    for (float y = -0.6f; y <= 0.6f; y += 0.03f) {
      const Vec3f at(x, y, 0), stripe = plank_colour(2 * x, y);
      const bool inside = at.norm() < kRadius;
      add_disc(inside ? fresh : fixed, at, Vec3f::UnitZ(), 0.02f, inside ? Vec3f(0.5f, 0.4f, 0.3f) : stripe);
      add_disc(truth, at, Vec3f::UnitZ(), 0.02f, stripe);
    }
  Wall out{fixed, fixed.size(), {}};
  out.cloud.append(fresh);
  for (int v = 0; v < 5; ++v) {
    const Camera camera = look_at({0.5 * (v - 2), -0.6, 1.2}, {0, 0, 0}, {0, 1, 0}, 90, 80, 110);
    FilledView view{camera, render(truth, camera).color, ImageU8(90, 80, 1)};
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 90; ++x) {
        const Vec3d ray = camera.ray(x + 0.5, y + 0.5), hit = camera.centre() - camera.centre().z() / ray.z() * ray;
        view.mask(x, y) = hit.norm() < kRadius;
      }
    out.views.push_back(view);
  }
  return out;
}

TEST(Refine, NewGaussiansTakeOnWhatTheViewsShowAndNoOthersMove) {
  Wall scene = wall();
  const GaussianCloud before = scene.cloud;
  RefineOptions options;
  options.rounds = 40;
  options.color_rate = 0.05f;
  const RefineSummary summary = refine(options, scene.views, scene.first_new, scene.cloud);
  EXPECT_TRUE(summary.kept);
  EXPECT_EQ(summary.views, 5u);
  EXPECT_LT(summary.mse_after, 0.05 * summary.mse_before);
  for (size_t p = 0; p < before.size(); ++p) {
    EXPECT_EQ(scene.cloud.position[p], before.position[p]);
    EXPECT_EQ(scene.cloud.rotation[p], before.rotation[p]);
    if (p >= scene.first_new) {
      EXPECT_LE((scene.cloud.log_scale[p] - before.log_scale[p]).cwiseAbs().maxCoeff(), options.most_scale + 1e-6f);
      continue;
    }
    ASSERT_EQ(scene.cloud.log_scale[p], before.log_scale[p]);
    ASSERT_EQ(scene.cloud.opacity_logit[p], before.opacity_logit[p]);
    for (int k = 0; k < 3; ++k) ASSERT_EQ(scene.cloud.sh_of(p)[k], before.sh_of(p)[k]);
  }
}

TEST(Refine, WhatCannotBeImprovedStaysAsItIs) {
  Wall scene = wall();
  for (FilledView& view : scene.views) view.color = render(scene.cloud, view.camera).color;
  const GaussianCloud before = scene.cloud;
  const RefineSummary summary = refine({}, scene.views, scene.first_new, scene.cloud);
  EXPECT_FALSE(summary.kept);
  EXPECT_LT(summary.mse_before, 1e-6);
  EXPECT_EQ(scene.cloud.sh, before.sh);
  EXPECT_EQ(scene.cloud.opacity_logit, before.opacity_logit);
}

TEST(Refine, PicturesAreThoseOfTheScenesRasteriser) {
  Wall scene = wall();
  RenderOptions antialiased;
  antialiased.antialiased = true;
  for (FilledView& view : scene.views) view.color = render(scene.cloud, view.camera, antialiased).color;
  GaussianCloud plain = scene.cloud;
  EXPECT_GT(refine({}, scene.views, scene.first_new, plain).mse_before, 1e-5);
  EXPECT_LT(refine({}, scene.views, scene.first_new, scene.cloud, antialiased).mse_before, 1e-6);
}

TEST(Refine, HolesLookAsInTheWholePicture) {
  // Balls beside the hole, whose footprints at its border depend on the frustum that their Jacobian is held in.
  Wall scene = wall();
  GaussianCloud cloud;
  for (const float side : {-1.0f, 1.0f}) {
    add_disc(cloud, {0.7f * side, 0, 0.3f}, Vec3f::UnitZ(), 0.25f, {0.9f, 0.1f, 0.1f});
    cloud.log_scale.back().setConstant(std::log(0.25f));
  }
  const size_t first_new = cloud.size() + scene.first_new;
  cloud.append(scene.cloud);
  for (FilledView& view : scene.views) view.color = render(cloud, view.camera).color;
  EXPECT_LT(refine({}, scene.views, first_new, cloud).mse_before, 1e-6);
}

TEST(Refine, EqualBitForBitForAnyNumberOfThreads) {
  Wall one = wall(), three = one;
  const int threads = omp_get_max_threads();
  omp_set_num_threads(1);
  refine({}, one.views, one.first_new, one.cloud);
  omp_set_num_threads(3);
  refine({}, three.views, three.first_new, three.cloud);
  omp_set_num_threads(threads);
  EXPECT_EQ(one.cloud.sh, three.cloud.sh);
  EXPECT_EQ(one.cloud.opacity_logit, three.cloud.opacity_logit);
}

}  // namespace
}  // namespace pliant
