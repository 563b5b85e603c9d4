// Scenes whose unit of length or origin spoils every result are named, others are not.

#include "gaussians/io/scene/doubtful.h"

#include <gtest/gtest.h>

#include "gaussians/base/orbit.h"
#include "tests/gaussians/made_photos.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// A ball of 300 Gaussians with its twelve cameras, multiplied by `scale` and then moved by `shift`.
std::vector<std::string> said(float scale, float shift, bool orbit = false) {
  GaussianCloud cloud = painted_ball(300, 5);
  std::vector<Camera> cameras = cameras_of(photos_of(cloud, 12, 56, 44));
  for (Vec3f& x : cloud.position) x = scale * x + Vec3f::Constant(shift);
  for (Vec3f& s : cloud.log_scale) s.array() += std::log(scale);
  for (Camera& camera : cameras) {
    camera.cam_from_world.translation() *= scale;
    camera.cam_from_world.translation() -= camera.cam_from_world.linear() * Vec3d::Constant(shift);
  }
  return doubtful_units("ball.ply", cloud, cameras, orbit);
}

TEST(DoubtfulUnits, OfAnOrdinarySceneNothingIsSaid) {
  for (const float scale : {0.2f, 1.0f, 100.0f}) EXPECT_TRUE(said(scale, 0).empty()) << scale;
  EXPECT_TRUE(said(1, 1000).empty());
}

TEST(DoubtfulUnits, WhatTheNearPlaneHidesIsNamedWithTheFactorThatMendsIt) {
  // Cameras at 3.6 units: their nearest Gaussians are 2.5 away.
  const std::vector<std::string> some = said(0.065f, 0);
  ASSERT_EQ(some.size(), 1u);
  EXPECT_NE(some[0].find("nearer than 0.2"), std::string::npos) << some[0];
  EXPECT_NE(some[0].find("--scale 10"), std::string::npos) << some[0];
  expect_error(Failure::kInput, {"ball.ply", "nearer", "--scale 100"}, [] { said(0.01f, 0); });
  EXPECT_EQ(said(0.01f, 0, true).size(), 1u) << "others may be given for an orbit";
}

TEST(DoubtfulUnits, CoordinatesThatSinglePrecisionDoesNotResolveAreNamed) {
  const std::vector<std::string> far = said(1, 1e6f);
  ASSERT_EQ(far.size(), 1u);
  EXPECT_NE(far[0].find("single precision"), std::string::npos) << far[0];
}

}  // namespace
}  // namespace pliant
