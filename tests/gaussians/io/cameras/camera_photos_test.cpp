// What files of cameras say of photos: where they are, their sizes, orientation and names.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/ply_points.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/describe.h"
#include "tests/gaussians/format_files.h"
#include "tests/gaussians/io/cameras/some_cameras.h"
#include "tests/gaussians/photo_files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

TEST(Cameras, DistortionIsKeptThroughTransformsAndReported) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras = some_cameras();
  for (Camera& camera : cameras) camera.distortion = {0.1, -0.05, 0.001, 0.002, 0, 0};
  EXPECT_TRUE(write_cameras(folder / "t.json", cameras).empty());
  const CameraFile file = read_cameras(folder / "t.json");
  EXPECT_EQ(file.cameras[2].distortion, cameras[2].distortion);
  const json described = describe(folder / "t.json");
  EXPECT_EQ(described["cameras"]["distortion"]["k1"], json({0.1, 0.1}));
  EXPECT_FALSE(described["cameras"]["distortion"].contains("k3"));
  EXPECT_NE(described["warnings"].dump().find("lens distortion (k1, k2, p1, p2) is removed by `reconstruct`"),
            std::string::npos);
}

TEST(Cameras, PathsOfPhotosMayBeThoseOfWindows) {
  const TemporaryFolder folder;
  EXPECT_TRUE(write_cameras(folder / "t.json", some_cameras()).empty());
  json file = json::parse(read_text(folder / "t.json"));
  size_t k = 0;
  for (json& frame : file["frames"]) {
    frame["file_path"] = (k % 2 ? "train\\a\\" : "train\\b\\") + std::to_string(k / 2) + ".png";
    frame.erase("camera_name");
    ++k;
  }
  write_text(folder / "t.json", file.dump());
  for (const char* photo : {"train/b/0.png", "train/a/0.png"}) {
    fs::create_directories((folder / photo).parent_path());
    write_image(folder / photo, ImageF(320, 240, 3));
  }
  const CameraFile read = read_cameras(folder / "t.json");
  ASSERT_EQ(read.photos_found, 2);
  EXPECT_EQ(fs::path(read.cameras[1].photo), folder / "train/a/0.png");
  EXPECT_EQ(read.cameras[0].name, "train_b_0");
  EXPECT_EQ(read.cameras[1].name, "train_a_0");
  EXPECT_EQ(name_of_photo("C:\\shots\\IMG_1.JPG"), "IMG_1");
  // A name that holds one is that of the file that there is.
  write_image(folder / "odd\\name.png", ImageF(320, 240, 3));
  EXPECT_EQ(find_photo({}, {folder / "."}, "odd\\name"), folder / "odd\\name.png");
}

TEST(Cameras, OfEverySizeFollowAPhotoOfTheirs) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras = some_cameras();
  const std::pair<int, int> sizes[] = {{1957, 1091}, {1959, 1089}, {1959, 1089}}, photos[] = {{489, 273}, {490, 272}};
  const auto write = [&](const std::string& name, std::pair<int, int> size) {
    folder.file(name, encoded(".png", picture_of(size.first, size.second, [](int, int, int) { return 0; })));
  };
  for (int i = 0; i < 3; ++i) {
    cameras[i] = cameras[i].resized(sizes[i].first, sizes[i].second);
    cameras[i].photo = (folder / (cameras[i].name + ".png")).string();
    write(cameras[i].name + ".png", photos[std::min(i, 1)]);
  }
  EXPECT_TRUE(write_cameras(folder / "t.json", cameras).empty());
  const CameraFile file = read_cameras(folder / "t.json");
  for (int i = 0; i < 3; ++i) {
    const auto& [width, height] = photos[std::min(i, 1)];
    EXPECT_EQ(file.cameras[i].width, width) << i;
    EXPECT_EQ(file.cameras[i].height, height) << i;
    EXPECT_NEAR(file.cameras[i].fx * sizes[i].first, cameras[i].fx * width, 1e-6) << i;
    EXPECT_NEAR(file.cameras[i].cy * sizes[i].second, cameras[i].cy * height, 1e-6) << i;
  }
  EXPECT_EQ(file.warnings.size(), 1u);
  // Sizes of cameras may be the rounded ones.
  for (int i = 0; i < 3; ++i) {
    write(cameras[i].name + ".png", sizes[i]);
    cameras[i] = cameras[i].resized(photos[std::min(i, 1)].first, photos[std::min(i, 1)].second);
  }
  EXPECT_TRUE(write_cameras(folder / "t.json", cameras).empty());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(read_cameras(folder / "t.json").cameras[i].height, sizes[i].second) << i;
  // One that cannot be read is scaled as the first.
  for (int i = 1; i < 3; ++i) folder.file(cameras[i].name + ".png", "no image");
  EXPECT_EQ(read_cameras(folder / "t.json").cameras[1].width, std::lround(490 * 1957.0 / 489));
}

TEST(Cameras, MayBeThoseOfPhotosThatTheirOrientationTurns) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras = some_cameras();
  const auto write_photos = [&](int width, int height, int orientation) {
    const std::string stored = encoded(".jpg", picture_of(width, height, [](int x, int, int) { return x; }));
    for (Camera& camera : cameras)
      camera.photo = folder.file(camera.name + ".jpg", with_orientation(stored, orientation, true)).string();
  };
  for (Camera& camera : cameras) camera = camera.resized(30, 40);
  for (const int scale : {1, 2}) {
    write_photos(40 * scale, 30 * scale, 6);
    EXPECT_TRUE(write_cameras(folder / "t.json", cameras).empty());
    const CameraFile file = read_cameras(folder / "t.json");
    EXPECT_EQ(file.cameras[1].width, 30 * scale);
    EXPECT_EQ(file.cameras[1].height, 40 * scale);
    EXPECT_NEAR(file.cameras[1].cx, scale * cameras[1].cx, 1e-6);
    EXPECT_EQ(file.warnings.size(), scale == 1 ? 0u : 1u);
  }
  write_photos(40, 30, 3);
  expect_error(Failure::kInput, {"view_0.jpg", "40 x 30", "30 x 40"}, [&] { read_cameras(folder / "t.json"); });
}

TEST(Cameras, NamesOfCamerasStayInTheFolderOfTheirFiles) {
  const TemporaryFolder folder;
  std::vector<Camera> cameras = some_cameras();
  cameras[0].name = "../escaped";
  cameras[1].name = "left\\..\\a.b";
  cameras[2].name = ".hidden.a";
  EXPECT_TRUE(write_cameras(folder / "t.json", cameras).empty());
  const CameraFile file = read_cameras(folder / "t.json");
  EXPECT_EQ(file.cameras[0].name, "_.._escaped");
  EXPECT_EQ(file.cameras[1].name, "left_.._a.b");
  EXPECT_EQ(file.cameras[2].name, "_.hidden.a");
}

TEST(Cameras, FindTheirPhotosThroughSymbolicLinks) {
  const TemporaryFolder folder;
  for (const char* name : {"real/deep/disk", "real/photos", "home"}) fs::create_directories(folder / name);
  fs::create_directory_symlink(folder / "real/deep/disk", folder / "scratch");
  fs::create_directory_symlink(folder / "real/photos", folder / "home/photos");
  std::vector<Camera> cameras = some_cameras();
  for (Camera& camera : cameras) {
    camera = camera.resized(64, 48);
    camera.photo = (folder / "home/photos" / (camera.name + ".png")).string();
    write_image(camera.photo, ImageF(64, 48, 3));
  }
  SparsePoints points;
  points.position = {Vec3f::Zero()};
  points.color = {Vec3f::Zero()};
  write_ply_points(folder / "home/points.ply", points);
  for (const char* name : {"scratch/t.json", "scratch/anew/t.json", "real/t.json", "home/t.json"}) {
    const fs::path file = folder / name;
    write_transforms(file, cameras, folder / "home/points.ply");
    const CameraFile read = read_cameras(file);
    EXPECT_EQ(read.photos_found, 3) << name;
    EXPECT_TRUE(fs::equivalent(read.cameras[1].photo, cameras[1].photo)) << name;
    EXPECT_TRUE(fs::equivalent(sparse_points_file(file), folder / "home/points.ply")) << name;
  }
  // A link beside the file is part of the name.
  EXPECT_EQ(json::parse(read_text(folder / "home/t.json"))["frames"][0]["file_path"], "photos/view_0.png");
}

TEST(Cameras, OfARigHaveThePhotosOfTheirOwnFolder) {
  const TemporaryFolder folder;
  json transforms = {{"w", 64}, {"h", 48}, {"fl_x", 50}};
  std::string images;
  for (int k = 0; k < 8; ++k) {
    const std::string photo = "cam" + std::to_string(k / 4) + "/000" + std::to_string(k % 4) + ".png";
    fs::create_directories((folder / "set/images" / photo).parent_path());
    write_image(folder / "set/images" / photo, ImageF(64, 48, 3));
    if (k == 3) continue;  // of the first folder three of four photos have a pose
    transforms["frames"].push_back({{"file_path", "images/" + photo},
                                    {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}});
    images += std::to_string(k) + " 1 0 0 0 0 0 0 1 " + photo + "\n\n";
  }
  folder.file("set/transforms.json", transforms.dump());
  folder.file("set/sparse/0/cameras.txt", "1 PINHOLE 64 48 50 50 32 24\n");
  folder.file("set/sparse/0/images.txt", images);
  fs::copy(folder / "set/images/cam0", folder / "left");
  for (const char* name : {"set/transforms.json", "set/sparse/0"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(read_cameras(folder / name, folder / "set/images").cameras.size(), 7u);
    const CameraFile file = read_cameras(folder / name, folder / "set/images/cam0");
    ASSERT_EQ(file.cameras.size(), 3u);
    EXPECT_EQ(file.photos_found, 3);
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(file.cameras[k].photo, (folder / ("set/images/cam0/000" + std::to_string(k) + ".png")).string());
    ASSERT_EQ(file.warnings.size(), 1u);
    EXPECT_NE(file.warnings[0].find("4 of 7 frames name photos that do not exist"), std::string::npos);
    expect_error(Failure::kInput, {"cam0/0000.png' and '", "cam1/0000.png'", "left/0000.png"},
                 [&] { read_cameras(folder / name, folder / "left"); });
  }
  const fs::path before = fs::current_path();
  fs::current_path(folder / "set/images/cam1");
  EXPECT_EQ(read_cameras(folder / "set/transforms.json", ".").cameras.size(), 4u);
  fs::current_path(before);
  // With as many of its folders as there are.
  folder.file("some/cam1/0000.png", "");
  folder.file("some/0000.png", "");
  EXPECT_EQ(find_photo(folder / "some", {}, "images/cam1/0000.png"), folder / "some/cam1/0000.png");
  EXPECT_EQ(find_photo(folder / "some", {}, "/mnt/images/cam2/0000.png"), folder / "some/0000.png");
}

TEST(Cameras, FindPhotosByTheirNamesWithoutSuffix) {
  for (const char* suffix : {"", ".png", ".PNG", ".jpg", ".JPG", ".Jpg", ".jpeg", ".JPEG", ".webp", ".WEBP", ".bmp",
                             ".BMP", ".tif", ".Tif", ".tiff", ".TIFF"}) {
    const TemporaryFolder folder;
    const fs::path photo = folder.file(std::string("images/r.0_") + suffix, "");
    EXPECT_EQ(find_photo({}, {folder.path()}, "images/r.0_"), photo);
    EXPECT_EQ(find_photo(folder / "images", {}, "train/r.0_"), photo);
    EXPECT_TRUE(find_photo({}, {folder.path()}, "images/r.0").empty());
  }
}

}  // namespace
}  // namespace pliant
