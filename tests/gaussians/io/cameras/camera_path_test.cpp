// Camera paths: nerfstudio's file, other camera files, the camera between two poses, framing, and malformed files.

#include "gaussians/io/cameras/camera_path.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

using nlohmann::json;

namespace pliant {
namespace {

/// As nerfstudio's viewer writes it: two poses a quarter turn about z apart, one metre along x.
json viewer_path() {
  const json first = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const json second = {0, -1, 0, 1, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return {{"camera_type", "perspective"},
          {"render_height", 480},
          {"render_width", 640},
          {"fps", 10},
          {"seconds", 0.2},
          {"crop", nullptr},
          {"keyframes", json::array()},
          {"camera_path",
           {{{"camera_to_world", first}, {"fov", 90}, {"aspect", 1.3333}},
            {{"camera_to_world", second}, {"fov", 60}, {"aspect", 1.3333}}}}};
}

TEST(CameraPath, TheVerticalFieldOfViewAndOpenGlAxesOfNerfstudio) {
  const TemporaryFolder folder;
  const CameraPath path = read_camera_path(folder.file("camera_path.json", viewer_path().dump()));
  EXPECT_EQ(path.fps, 10);
  EXPECT_DOUBLE_EQ(path.duration(), 0.1);
  ASSERT_EQ(path.cameras.size(), 2u);
  const Camera& first = path.cameras[0];
  EXPECT_EQ(first.width, 640);
  EXPECT_EQ(first.height, 480);
  // What stands 45 degrees above the axis is on the upper edge of a picture with a field of view of 90 degrees.
  const Eigen::Vector3d edge = first.cam_from_world * Eigen::Vector3d(0, 1, -1);
  EXPECT_NEAR(first.fy * edge.y() / edge.z() + first.cy, 0, 1e-9);
  EXPECT_TRUE(first.forward().isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_TRUE(path.cameras[1].centre().isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(CameraPath, BetweenTwoPosesTheTurnIsEvenAndTheCentreMovesStraight) {
  const TemporaryFolder folder;
  const CameraPath path = read_camera_path(folder.file("camera_path.json", viewer_path().dump()));
  const Eigen::Matrix3d start = path.cameras[0].cam_from_world.linear();
  for (const double u : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const Camera camera = path.at(u / path.fps);
    EXPECT_TRUE(camera.centre().isApprox(Eigen::Vector3d(u, 0, 0), 1e-12) || u == 0);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(camera.cam_from_world.linear() * start.transpose()));
    EXPECT_NEAR(turn.angle(), u * M_PI / 2, 1e-6);
    EXPECT_NEAR(camera.fx, (1 - u) * path.cameras[0].fx + u * path.cameras[1].fx, 1e-9);
  }
  EXPECT_TRUE(path.at(-3).cam_from_world.isApprox(path.cameras[0].cam_from_world));
  EXPECT_TRUE(path.at(99).cam_from_world.isApprox(path.cameras[1].cam_from_world));
}

TEST(CameraPath, IsAnyCameraFileInItsOrder) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras;
  for (int k = 0; k < 3; ++k) {
    cameras.push_back(look_at({2, 0.5 * k, 1}, {0, 0, 0}, {0, 0, 1}, 64, 48, 50));
    cameras.back().name = std::string(1, static_cast<char>('a' + k));
  }
  write_transforms(folder / "transforms.json", cameras);
  EXPECT_FALSE(is_camera_path(folder / "transforms.json"));
  const CameraPath path = read_camera_path(folder / "transforms.json");
  EXPECT_EQ(path.fps, 30);
  ASSERT_EQ(path.cameras.size(), 3u);
  EXPECT_TRUE(path.cameras[2].centre().isApprox(Eigen::Vector3d(2, 1, 1), 1e-6));
  cameras[1].width = 32;
  write_transforms(folder / "transforms.json", cameras);
  EXPECT_THROW(read_camera_path(folder / "transforms.json"), Error);
}

TEST(CameraPath, NamesOfPosesAreInTheirOrder) {
  const TemporaryFolder folder;
  json file = viewer_path();
  for (int k = 2; k < 11; ++k) file["camera_path"].push_back(file["camera_path"][0]);
  const CameraPath path = read_camera_path(folder.file("camera_path.json", file.dump()));
  EXPECT_EQ(path.cameras.front().name, "00");
  EXPECT_EQ(path.cameras[9].name, "09");
  EXPECT_EQ(path.cameras.back().name, "10");
}

TEST(CameraPath, ViewsNeedNoPhotosAndTheirLensIsWarnedOf) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras;
  for (int k = 0; k < 3; ++k) {
    cameras.push_back(look_at({2, 0.5 * k, 1}, {0, 0, 0}, {0, 0, 1}, 64, 48, 50));
    cameras.back().name = std::string(1, static_cast<char>('a' + k));
    cameras.back().distortion[0] = 0.1;
  }
  // Of one of them there is a photo, which is half as large.
  write_image(folder / "b.png", ImageF(32, 24, 3));
  write_transforms(folder / "transforms.json", cameras);
  const CameraPath path = read_camera_path(folder / "transforms.json");
  ASSERT_EQ(path.cameras.size(), 3u);
  for (const Camera& camera : path.cameras) EXPECT_EQ(camera.width, 32);
  ASSERT_EQ(path.warnings.size(), 2u);
  EXPECT_NE(path.warnings[0].find("the cameras are scaled to the photos"), std::string::npos) << path.warnings[0];
  EXPECT_NE(path.warnings[1].find("lens distortion (k1)"), std::string::npos) << path.warnings[1];
  // A photo that is no image is none.
  folder.file("b.png", "no image");
  EXPECT_EQ(read_camera_path(folder / "transforms.json").cameras[0].width, 64);
}

TEST(CameraPath, CamerasOfColmapFollowTheNumbersOfTheirPhotos) {
  const TemporaryFolder folder;
  folder.file("cameras.txt", "1 PINHOLE 64 48 50 50 32 24\n");
  std::string images;
  for (const int photo : {10, 2, 1, 9})
    images += std::to_string(20 - photo) + " 1 0 0 0 " + std::to_string(photo) + " 0 0 1 film/f" +
              std::to_string(photo) + ".png\n\n";
  folder.file("images.txt", images);
  const auto names = [&] {
    std::string all;
    for (const Camera& camera : read_camera_path(folder.path()).cameras) all += camera.name + " ";
    return all;
  };
  EXPECT_EQ(names(), "f1 f2 f9 f10 ");
  std::filesystem::create_directory(folder / "film");
  for (const int photo : {10, 2, 1, 9})
    write_image(folder / ("film/f" + std::to_string(photo) + ".png"), ImageF(64, 48, 3));
  EXPECT_EQ(names(), "f1 f2 f9 f10 ");
}

TEST(CameraPath, MalformedFilesNameThePoseAndTheKey) {
  const TemporaryFolder folder;
  const auto refused = [&](const char* pointer, const json& value, const std::string& field) {
    json file = viewer_path();
    file[json::json_pointer(pointer)] = value;
    const auto path = folder.file("camera_path.json", file.dump());
    SCOPED_TRACE(pointer);
    expect_error(Failure::kInput, {"camera_path.json", field}, [&] { read_camera_path(path); });
  };
  refused("/camera_type", "equirectangular", "camera_type");
  refused("/crop", {{"crop_center", {0, 0, 0}}}, "crop");
  refused("/fps", 0, "fps");
  refused("/fps", "fast", "fps");
  refused("/render_width", -640, "render_width");
  refused("/render_height", 1e9, "render_height");
  refused("/camera_path", json::array(), "camera_path");
  refused("/camera_path", 7, "camera_path");
  refused("/camera_path/1", "pose", "camera_path[1]");
  refused("/camera_path/1/fov", 180, "fov");
  refused("/camera_path/1/fov", nullptr, "fov");
  refused("/camera_path/1/camera_to_world", {1, 2, 3}, "camera_to_world");
  refused("/camera_path/1/camera_to_world/0", 3, "camera_to_world");
  refused("/camera_path/1/camera_to_world/15", 2, "camera_to_world");
}

TEST(Camera, AFramedPictureCutsNothingAndKeepsSquares) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500;
  camera.fy = 510;
  camera.cx = 330;
  camera.cy = 235;
  const auto pixel = [](const Camera& c, double x, double y) {
    return Eigen::Vector2d((x - c.cx) / c.fx, (y - c.cy) / c.fy);
  };
  for (const auto& [width, height] : {std::pair(1920, 1080), std::pair(300, 900), std::pair(1280, 960)}) {
    const Camera framed = camera.framed(width, height);
    EXPECT_EQ(framed.width, width);
    EXPECT_EQ(framed.height, height);
    EXPECT_NEAR(framed.fx / framed.fy, camera.fx / camera.fy, 1e-12);
    // The rays of the old corners lie inside of the new picture, those of two edges on its own.
    const Eigen::Vector2d low = pixel(camera, 0, 0), high = pixel(camera, 640, 480);
    const Eigen::Vector2d new_low = pixel(framed, 0, 0), new_high = pixel(framed, width, height);
    EXPECT_TRUE(((low - new_low).array() >= -1e-12).all() && ((new_high - high).array() >= -1e-12).all());
    EXPECT_NEAR(((low - new_low).array() * (new_high - high).array()).abs().minCoeff(), 0, 1e-12);
    EXPECT_TRUE(pixel(framed, 0.5 * width, 0.5 * height).isApprox(pixel(camera, 320, 240), 1e-12));
  }
}

}  // namespace
}  // namespace pliant
