// Scene folders of PhysDreamer: roles of the point files, videos and their cameras, the simulation's cube.

#include "app/import/physdreamer_folder.h"

#include <algorithm>

#include "gaussians/base/random.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/images/video.h"
#include "gaussians/io/splats/ply.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// A stalk along z from 0 to 1, whose upper half moves, on a floor that is no part of it.
struct PhysDreamer : testing::Test {
  TemporaryFolder folder;
  GaussianCloud cloud;

  void write_points(const std::string& name, const std::vector<Vec3f>& points) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(points.size()) +
                       "\nproperty double x\nproperty double y\nproperty double z\nelement face 0\nproperty list uchar "
                       "int vertex_indices\nend_header\n";
    for (const Vec3f& x : points)
      text += std::to_string(x.x()) + " " + std::to_string(x.y()) + " " + std::to_string(x.z()) + "\n";
    folder.file(name, text);
  }

  PhysDreamer() {
    std::vector<Vec3f> object, moving, filled;
    for (int i = 0; i < 200; ++i) {
      const bool stalk = i < 100;
      const Vec3f x =
          stalk ? Vec3f(0.03f * (i % 3), 0.2f, i / 99.0f) : Vec3f(0.1f * (i % 10), 0.1f * (i / 10 - 10), -0.2f);
      cloud.resize(i + 1);
      cloud.position[i] = x;
      if (stalk) object.push_back(x + Vec3f(0.004f, 0, 0));
      if (stalk && x.z() > 0.5f) moving.push_back(x);
      if (stalk) filled.push_back(x + Vec3f(0, 0.01f, 0));
    }
    write_ply(folder / "point_cloud.ply", cloud);
    write_points("clean_object_points.ply", object);
    write_points("moving_part_points.ply", moving);
    write_points("internal_filled_points.ply", filled);
    std::filesystem::create_directories(folder / "images");
    std::filesystem::create_directories(folder / "videos");
    std::filesystem::create_directories(folder / "masks");
    std::vector<Camera> cameras;
    for (const char* name : {"frame_1", "frame_10", "frame_2"}) {
      Camera camera = look_at({3, 0, 0.5}, {0, 0, 0.5}, {0, 0, 1}, 64, 48, 60);
      camera.name = name;
      camera.photo = (folder / "images" / (std::string(name) + ".png")).string();
      write_image(camera.photo, ImageF(64, 48, 3, 0.5f));
      cameras.push_back(camera);
    }
    write_transforms(folder / "transforms_train.json", cameras);
    write_image(folder / "masks/frame_10_mask.png", ImageF(64, 48, 3, 1.0f));
    VideoWriter video(folder / "videos/frame_10_push.mp4", 8, 64, 36);
    for (int f = 0; f < 4; ++f) video.write(ImageF(64, 36, 3, 0.2f * f));
    video.close();
  }
};

TEST_F(PhysDreamer, AFolderIsReadAsItIs) {
  EXPECT_TRUE(is_physdreamer_folder(folder.path()));
  folder.file("sim_fields.pt", "x");
  const PhysDreamerFolder read = read_physdreamer_folder(folder.path());
  EXPECT_EQ(read.object_points.size(), 100u);
  EXPECT_EQ(read.moving_points.size(), 50u);
  EXPECT_EQ(read.filled_points.size(), 100u);
  EXPECT_TRUE(read.stem_points.empty());
  ASSERT_EQ(read.videos.size(), 1u);
  EXPECT_EQ(read.videos[0].camera, "frame_10");
  ASSERT_TRUE(read.settings.video);
  EXPECT_EQ(read.settings.video->camera, "frame_10");
  EXPECT_DOUBLE_EQ(read.settings.video->fps, 30);
  EXPECT_EQ(read.masks.size(), 1u);
  ASSERT_NE(read.find_video(folder / "videos/../videos/frame_10_push.mp4"), nullptr);
  EXPECT_EQ(read.find_video(folder / "elsewhere/frame_10_push.mp4"), nullptr);
  EXPECT_EQ(read.material_field.filename(), "sim_fields.pt");
  EXPECT_TRUE(read.velocity_field.empty());
  // The scene itself loads by the folder's name, with these Gaussians and cameras.
  const Scene scene = load_scene(folder.path());
  EXPECT_EQ(scene.cloud.size(), 200u);
  EXPECT_EQ(scene.cameras.size(), 3u);
}

TEST_F(PhysDreamer, PointFilesSayWhatIsSimulatedAndWhatIsHeld) {
  const PhysDreamerFolder read = read_physdreamer_folder(folder.path());
  const PhysDreamerRoles roles = physdreamer_roles({}, read, cloud.position);
  const double distance = 0.5 / 64 * roles.space.scale;
  for (size_t i = 0; i < 200; ++i) {
    EXPECT_EQ(roles.object[i], i < 100) << i;
    // The lowest moving point is number 50; neighbours on the stalk are less than 0.07 apart.
    if (i < 42) {
      EXPECT_TRUE(roles.frozen[i] && roles.frozen_filled[i]) << i << ' ' << distance;
    }
    if (i >= 50) {
      EXPECT_FALSE(roles.frozen[i]) << i;
    }
  }
  EXPECT_TRUE(roles.warnings.empty());
  // Released constants: the cube has 1.8 times the extent over all axes, and a quarter of it as margin below.
  EXPECT_NEAR(roles.space.scale, 1.8, 1e-6);
  EXPECT_NEAR(roles.space.inside(Vec3d(0, 0, 0)).z(), 0.25 / 1.8, 1e-6);
  EXPECT_NEAR(roles.space.inside(Vec3d(0, 0, 1)).z(), 1.25 / 1.8, 1e-6);
  const Vec3d x(0.3, -0.1, 0.7);
  EXPECT_LT((roles.space.world(roles.space.inside(x)) - x).norm(), 1e-12);
  EXPECT_NEAR(roles.space.field_high.z() - roles.space.field_low.z(), 1.2 / 1.8, 1e-6);
}

TEST_F(PhysDreamer, FramesInVideosBelongToTheCameraOfTheFoldersName) {
  std::filesystem::remove(folder / "videos/frame_10_push.mp4");
  EXPECT_EQ(read_physdreamer_folder(folder.path()).videos.size(), 0u);
  std::filesystem::create_directories(folder / "videos/frame_2");
  for (const char* file : {"videos/frame_2/0.png", "videos/frame_2/1.png"}) write_image(folder / file, ImageF(8, 8, 3));
  const PhysDreamerFolder in_folder = read_physdreamer_folder(folder.path());
  ASSERT_EQ(in_folder.videos.size(), 1u);
  EXPECT_EQ(in_folder.videos[0].camera, "frame_2");
  std::filesystem::remove_all(folder / "videos/frame_2");
  write_image(folder / "videos/0.png", ImageF(8, 8, 3));
  const PhysDreamerFolder unnamed = read_physdreamer_folder(folder.path());
  ASSERT_EQ(unnamed.videos.size(), 1u);
  EXPECT_EQ(unnamed.videos[0].camera, "");
  EXPECT_FALSE(unnamed.settings.video);
  EXPECT_TRUE(std::any_of(unnamed.warnings.begin(), unnamed.warnings.end(),
                          [](const std::string& w) { return w.find("any of the 3") != std::string::npos; }));
}

TEST_F(PhysDreamer, AVideoOfAnotherShapeKeepsTheHorizontalFieldOfView) {
  const Camera camera = look_at({3, 0, 0.5}, {0, 0, 0.5}, {0, 0, 1}, 64, 48, 60);
  const Camera video = physdreamer_camera(camera, 128, 72);
  EXPECT_NEAR(video.width / video.fx, camera.width / camera.fx, 1e-12);
  EXPECT_NEAR(video.fx, video.fy, 1e-12);
  EXPECT_NEAR(video.cy, 36, 1e-12);
}

TEST_F(PhysDreamer, AMaskHasTheHorizontalFieldOfViewOfItsCamera) {
  // A bright disc about the middle, beside it to the right a bright column.
  ImageF mask(64, 48, 3);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) mask(x, y, c) = std::hypot(x + 0.5 - 32, y + 0.5 - 24) < 10 || x >= 60;
  write_image(folder / "masks/frame_10_mask.png", mask);
  const PhysDreamerFolder read = read_physdreamer_folder(folder.path());
  Camera camera = look_at({3, 0, 0.5}, {0, 0, 0.5}, {0, 0, 1}, 64, 48, 60);
  EXPECT_TRUE(physdreamer_mask(read, camera).data.empty());
  camera.name = "frame_10";
  for (const auto& [width, height] : {std::pair{64, 48}, {64, 36}, {128, 72}, {128, 128}}) {
    const Camera video = physdreamer_camera(camera, width, height);
    const ImageF seen = physdreamer_mask(read, video);
    ASSERT_TRUE(seen.width == width && seen.height == height && seen.channels == 1);
    // What a ray hits is the same in all of them.
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double u = (x + 0.5 - video.cx) / video.fx * camera.fx + camera.cx,
                     v = (y + 0.5 - video.cy) / video.fy * camera.fy + camera.cy;
        const bool inside = v > 0 && v < 48;
        EXPECT_EQ(seen(x, y), inside ? mask(static_cast<int>(u), static_cast<int>(v), 0) : 0)
            << width << ' ' << x << ' ' << y;
      }
  }
}

TEST_F(PhysDreamer, WhatIsMissingIsNamed) {
  std::filesystem::remove(folder / "moving_part_points.ply");
  expect_error(Failure::kInput, {"moving_part_points.ply", "is missing"},
               [&] { read_physdreamer_folder(folder.path()); });
  write_points("moving_part_points.ply", {{50, 0, 0}});
  const PhysDreamerRoles held = physdreamer_roles({}, read_physdreamer_folder(folder.path()), cloud.position);
  ASSERT_EQ(held.warnings.size(), 1u);
  EXPECT_NE(held.warnings[0].find("is fixed"), std::string::npos);
  write_points("clean_object_points.ply", {{50, 0, 0}});
  expect_error(Failure::kInput, {"clean_object_points.ply", "0.01"},
               [&] { physdreamer_roles({}, read_physdreamer_folder(folder.path()), cloud.position); });
  std::filesystem::remove(folder / "transforms_train.json");
  expect_error(Failure::kInput, {"transforms_train.json", "sparse/0"}, [&] { read_physdreamer_folder(folder.path()); });
  std::filesystem::remove(folder / "point_cloud.ply");
  EXPECT_FALSE(is_physdreamer_folder(folder.path()));
}

}  // namespace
}  // namespace pliant
