// `convert` and `info` take every format, and refuse what does not fit with the right exit code.

#include <gtest/gtest.h>

#include "gaussians/base/orbit.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/splats/splats.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

GaussianCloud few() {
  GaussianCloud cloud;
  cloud.sh_degree = 1;
  cloud.resize(3);
  for (int i = 0; i < 3; ++i) {
    cloud.position[i] = Vec3f(0.25f * i, 0.5f, -1);
    cloud.sh_of(i)[5] = 0.25f * i;
  }
  return cloud;
}

TEST(Convert, SplatsBecomeAnyFormatThatIsWritten) {
  const TemporaryFolder folder;
  write_splats(folder / "a.ply", few());
  std::string from = (folder / "a.ply").string();
  for (const char* name : {"b.spz", "c.ply", "d.splat", "e.spz"}) {
    const std::string to = (folder / name).string();
    EXPECT_EQ(run_quietly({"convert", from, to}), 0);
    const GaussianCloud cloud = read_splats(to);
    ASSERT_EQ(cloud.size(), 3u);
    EXPECT_EQ(cloud.position[2], few().position[2]);
    from = to;
  }
  EXPECT_EQ(read_splats(folder / "c.ply").sh_of(2)[5], 0.5f);
  EXPECT_EQ(run_quietly({"info", (folder / "b.spz").string(), (folder / "d.splat").string(), "--json"}), 0);
  EXPECT_EQ(run_quietly({"convert", from, (folder / "b.spz").string()}), 2);  // it exists
  EXPECT_EQ(run_quietly({"convert", from, (folder / "b.spz").string(), "--overwrite", "--sh-degree", "0"}), 0);
  EXPECT_EQ(read_splats(folder / "b.spz").sh_degree, 0);
  EXPECT_EQ(run_quietly({"convert", from, (folder / "f.glb").string()}), 0);
  EXPECT_EQ(read_text(folder / "f.glb").substr(0, 4), "glTF");
  EXPECT_EQ(run_quietly({"convert", from, (folder / "f.ksplat").string()}), 2);
  EXPECT_EQ(run_quietly({"convert", from, (folder / "f.json").string()}), 2);
  EXPECT_EQ(run_quietly({"convert", from, (folder / "f.ply").string(), "--level", "2"}), 2);
  EXPECT_EQ(run_quietly({"convert", from, (folder / "f.ply").string(), "--level", "-1"}), 2);
  EXPECT_EQ(run_quietly({"info", folder.file("broken.spz", "NGSP")}), 1);
}

TEST(Convert, SplatsWithoutAMarkAreMarkedAsAntialiased) {
  const TemporaryFolder folder;
  write_splats(folder / "a.ply", few());
  for (const char* name : {"b.ply", "b.spz"}) {
    ASSERT_EQ(run_quietly({"convert", (folder / "a.ply").string(), (folder / name).string(), "--antialiased"}), 0);
    ReadReport report;
    read_splats(folder / name, &report);
    EXPECT_TRUE(report.antialiased) << name;
  }
}

TEST(Convert, SplatsAndCamerasAreScaledAlike) {
  const TemporaryFolder folder;
  write_splats(folder / "a.ply", few());
  Camera camera = look_at({1, 2, 3}, {0, 0, 0}, {0, 0, 1}, 64, 48, 60);
  camera.name = "a";
  write_cameras(folder / "cameras.json", {camera});
  ASSERT_EQ(run_quietly({"convert", (folder / "a.ply").string(), (folder / "b.ply").string(), "--scale", "10"}), 0);
  ASSERT_EQ(run_quietly({"convert", (folder / "cameras.json").string(), (folder / "b.json").string(), "--scale", "10"}),
            0);
  const GaussianCloud before = few(), after = read_splats(folder / "b.ply");
  const Camera moved = read_cameras(folder / "b.json").cameras.at(0);
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_LT((after.position[i] - 10 * before.position[i]).norm(), 1e-5f);
    EXPECT_NEAR(after.log_scale[i][0] - before.log_scale[i][0], std::log(10.0f), 1e-5);
    const Vec3d p = camera.cam_from_world * before.position[i].cast<double>(),
                q = moved.cam_from_world * after.position[i].cast<double>();
    EXPECT_LT((q - 10 * p).norm(), 1e-5);
  }
  EXPECT_EQ(run_quietly({"convert", (folder / "a.ply").string(), (folder / "c.ply").string(), "--scale", "0"}), 2);
}

TEST(Convert, FilesWithoutUsableGaussiansAreRefused) {
  const TemporaryFolder folder;
  GaussianCloud unusable = few();
  for (Vec3f& x : unusable.position) x[0] = NAN;
  write_splats(folder / "nan.ply", unusable);
  write_splats(folder / "none.ply", GaussianCloud());
  for (const char* in : {"nan.ply", "none.ply"})
    for (const char* out : {"out.ply", "out.splat", "out.spz", "out.glb"}) {
      testing::internal::CaptureStderr();
      EXPECT_EQ(run_pliant({"convert", (folder / in).string(), (folder / out).string()}), 1) << in << " to " << out;
      const std::string said = testing::internal::GetCapturedStderr();
      EXPECT_NE(said.find("contains no usable Gaussians"), std::string::npos) << said;
      EXPECT_NE(said.find(in), std::string::npos) << said;
      EXPECT_FALSE(std::filesystem::exists(folder / out));
    }
}

TEST(Convert, WhatIsUpIsKept) {
  const TemporaryFolder folder;
  write_splats(folder / "a.ply", few(), false, true);
  const std::string in = (folder / "a.ply").string();
  ASSERT_EQ(run_quietly({"convert", in, (folder / "b.ply").string(), "--scale", "2"}), 0);
  ReadReport report;
  read_splats(folder / "b.ply", &report);
  EXPECT_TRUE(report.z_is_up);
  ASSERT_EQ(run_quietly({"convert", in, (folder / "b.spz").string()}), 0);
  const GaussianCloud turned = read_splats(folder / "b.spz", &report);
  for (size_t i = 0; i < 3; ++i) {
    const Vec3f x = few().position[i];
    EXPECT_LT((turned.position[i] - Vec3f(x[0], -x[2], x[1])).norm(), 1e-4f);  // z up is y down
  }
}

TEST(Convert, PointsOfStructureFromMotionGoWithTheirCameras) {
  const TemporaryFolder folder;
  folder.file("sparse/0/cameras.txt", "1 PINHOLE 64 48 50 51 32 24\n");
  folder.file("sparse/0/images.txt", "1 1 0 0 0 1 2 3 1 a.png\n\n2 0 1 0 0 1 2 3 1 b.png\n\n");
  folder.file("sparse/0/points3D.txt", "1 1 2 3 255 0 51 0.5\n2 4 5 6 0 0 0 0.5\n");
  const std::string model = (folder / "sparse/0").string(), out = (folder / "t.json").string();
  ASSERT_EQ(run_quietly({"convert", model, out, "--scale", "10"}), 0);
  const SparsePoints points = read_sparse_points(out, read_cameras(out).cameras);
  ASSERT_EQ(points.position.size(), 2u);
  EXPECT_EQ(points.position[1], Vec3f(40, 50, 60));
  EXPECT_LT((points.color[0] - Vec3f(1, 0, 0.2f)).norm(), 1e-6f);
  // Neither file is replaced unasked.
  std::filesystem::remove(out);
  EXPECT_EQ(run_quietly({"convert", model, out}), 2);
  EXPECT_EQ(run_quietly({"convert", model, out, "--overwrite"}), 0);
  // Damaged points do not keep the cameras from being converted.
  folder.file("sparse/0/points3D.txt", "damaged\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant({"convert", model, (folder / "u.json").string()}), 0);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("the points are left out"), std::string::npos);
  EXPECT_EQ(read_cameras(folder / "u.json").cameras.size(), 2u);
}

TEST(Convert, ObjectFeaturesThatAreLostAreNamed) {
  const TemporaryFolder folder;
  std::string names;
  for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
                           "rot_0", "rot_1", "rot_2", "rot_3", "obj_dc_0"})
    names += std::string("property float ") + name + "\n";
  const std::string in = folder.file("gg.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + names +
                                                   "end_header\n0 0 0 0 0 0 1 -3 -3 -3 1 0 0 0 0.5\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_pliant({"convert", in, (folder / "out.ply").string()}), 0);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("obj_dc_*"), std::string::npos);
}

TEST(Convert, CamerasBecomeTransformsOrCamerasJson) {
  const TemporaryFolder folder;
  folder.file("sparse/0/cameras.txt", "1 OPENCV 64 48 50 51 32 24 0.1 0 0 0\n");
  folder.file("sparse/0/images.txt", "1 1 0 0 0 1 2 3 1 a.png\n\n2 0 1 0 0 1 2 3 1 b.png\n\n");
  const std::string transforms = (folder / "t.json").string();
  EXPECT_EQ(run_quietly({"convert", (folder / "sparse/0").string(), transforms}), 0);
  const std::vector<Camera> cameras = read_cameras(transforms).cameras;
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].fy, 51);
  EXPECT_EQ(cameras[1].distortion[0], 0.1);
  EXPECT_EQ(run_quietly({"convert", transforms, (folder / "cameras.json").string()}), 0);
  EXPECT_TRUE(
      read_cameras(folder / "cameras.json").cameras[1].cam_from_world.isApprox(cameras[1].cam_from_world, 1e-9));
  EXPECT_EQ(run_quietly({"convert", transforms, (folder / "x.ply").string()}), 1);
  EXPECT_EQ(run_quietly({"info", (folder / "sparse/0").string(), transforms}), 0);
}

}  // namespace
}  // namespace pliant
