// Cameras of COLMAP, 3DGS and Middlebury: the same views in every format, where they are found, and hostile files.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "gaussians/io/scene/describe.h"
#include "gaussians/io/scene/scene.h"
#include "gaussians/io/splats/ply.h"
#include "tests/gaussians/format_files.h"
#include "tests/gaussians/io/cameras/some_cameras.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

struct ColmapModel {
  int id;
  const char* name;
  std::vector<double> parameters;
  std::array<double, 6> distortion;
  bool one_focal;
};
const ColmapModel kModels[] = {
    {0, "SIMPLE_PINHOLE", {500, 310, 250}, {}, true},
    {1, "PINHOLE", {500, 510, 310, 250}, {}, false},
    {2, "SIMPLE_RADIAL", {500, 310, 250, 0.1}, {0.1}, true},
    {3, "RADIAL", {500, 310, 250, 0.1, 0.2}, {0.1, 0.2}, true},
    {4, "OPENCV", {500, 510, 310, 250, 0.1, 0.2, 0.3, 0.4}, {0.1, 0.2, 0.3, 0.4}, false},
};

std::string binary_cameras(int model, const std::vector<double>& parameters) {
  std::string bytes;
  put(bytes, uint64_t(1));
  put(bytes, uint32_t(7));
  put(bytes, int32_t(model));
  put(bytes, uint64_t(640));
  put(bytes, uint64_t(480));
  for (double value : parameters) put(bytes, value);
  return bytes;
}

std::string binary_images(const std::vector<Camera>& cameras) {
  std::string bytes;
  put(bytes, uint64_t(cameras.size()));
  for (const Camera& camera : cameras) {
    const Eigen::Quaterniond q(camera.cam_from_world.linear());
    const Eigen::Vector3d t = camera.cam_from_world.translation();
    put(bytes, uint32_t(bytes.size()));
    for (double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) put(bytes, value);
    put(bytes, uint32_t(7));
    bytes += "a/" + camera.name + ".png" + '\0';
    put(bytes, uint64_t(2));
    bytes += std::string(48, '\1');
  }
  return bytes;
}

std::string text_cameras(const ColmapModel& model) {
  std::string text = "# Camera list\r\n\r\n7 " + std::string(model.name) + " 640 480";
  for (double value : model.parameters) text.append(" ").append(std::to_string(value));
  return text + "\r\n";
}

std::string text_images(const std::vector<Camera>& cameras) {
  std::string text = "# Image list with two lines of data per image:\n";
  int id = 0;
  for (const Camera& camera : cameras) {
    const Eigen::Quaterniond q(camera.cam_from_world.linear());
    const Eigen::Vector3d t = camera.cam_from_world.translation();
    char line[400];
    std::snprintf(line, sizeof line, "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g 7 a/%s.png\n", ++id, q.w(), q.x(),
                  q.y(), q.z(), t.x(), t.y(), t.z(), camera.name.c_str());
    text += line + std::string(id == 2 ? "\n" : "1 2 -1 3 4 5\n");
  }
  return text;
}

void expect_same_views(const std::vector<Camera>& expected, const std::vector<Camera>& found) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].name, expected[i].name);
    EXPECT_TRUE(found[i].cam_from_world.isApprox(expected[i].cam_from_world, 1e-9)) << i;
    EXPECT_EQ(found[i].width, expected[i].width);
    EXPECT_EQ(found[i].height, expected[i].height);
  }
}

TEST(Colmap, EveryModelIsReadFromBinaryAndText) {
  const std::vector<Camera> cameras = some_cameras();
  for (const ColmapModel& model : kModels) {
    for (const bool binary : {true, false}) {
      SCOPED_TRACE(std::string(model.name) + (binary ? " binary" : " text"));
      const TemporaryFolder folder;
      if (binary) {
        folder.file("sparse/0/cameras.bin", binary_cameras(model.id, model.parameters));
        folder.file("sparse/0/images.bin", binary_images(cameras));
        folder.file("sparse/0/rigs.bin", "ignored");
        folder.file("sparse/0/cameras.txt", "binary wins");
        folder.file("sparse/0/images.txt", "binary wins");
      } else {
        folder.file("sparse/0/cameras.txt", text_cameras(model));
        folder.file("sparse/0/images.txt", text_images(cameras));
      }
      for (const char* path : {"", "sparse/0", binary ? "sparse/0/images.bin" : "sparse/0/cameras.txt"}) {
        const CameraFile file = read_cameras(folder / path);
        expect_same_views(cameras, file.cameras);
        const Camera& camera = file.cameras[0];
        EXPECT_EQ(camera.fx, 500);
        EXPECT_EQ(camera.fy, model.one_focal ? 500 : 510);
        EXPECT_EQ(camera.cx, 310);
        EXPECT_EQ(camera.cy, 250);
        EXPECT_EQ(camera.distortion, model.distortion);
        EXPECT_EQ(file.warnings.size(), camera.distortion[0] != 0 ? 2u : 1u);  // no photos; distortion
      }
    }
  }
}

TEST(Colmap, PhotosAreFoundInTheImagesFolderOfTheModel) {
  const TemporaryFolder folder;
  folder.file("sparse/0/cameras.bin", binary_cameras(1, kModels[1].parameters));
  folder.file("sparse/0/images.bin", binary_images(some_cameras()));
  for (const char* name : {"images/a/view_0.png", "images/a/view_2.png"}) {
    fs::create_directories(folder / "images/a");
    write_image(folder / name, ImageF(320, 240, 3));
  }
  const CameraFile file = read_cameras(folder / "sparse/0");
  ASSERT_EQ(file.cameras.size(), 2u);
  EXPECT_EQ(file.photos_found, 2);
  EXPECT_EQ(fs::path(file.cameras[1].photo), (folder / "images/a/view_2.png"));
  EXPECT_EQ(file.cameras[1].fx, 250);  // the cameras follow the photos
}

TEST(Colmap, OfNerfstudioLiesAFolderDeeperThanItsPhotos) {
  const TemporaryFolder folder;
  folder.file("colmap/sparse/0/cameras.bin", binary_cameras(1, kModels[1].parameters));
  folder.file("colmap/sparse/0/images.bin", binary_images(some_cameras()));
  fs::create_directories(folder / "images/a");
  write_image(folder / "images/a/view_1.png", ImageF(640, 480, 3));
  EXPECT_EQ(read_cameras(folder / "colmap/sparse/0").photos_found, 1);
}

TEST(Colmap, HostileFilesNameFileRecordAndValue) {
  const TemporaryFolder folder;
  const std::string cameras = binary_cameras(1, kModels[1].parameters), images = binary_images(some_cameras());
  const auto with = [](std::string bytes, size_t at, const std::string& change) {
    return bytes.replace(at, change.size(), change);
  };
  const std::string many(8, '\x7f'),
      nan =
          [] {
            std::string b;
            put(b, double(NAN));
            return b;
          }(),
      zeros(32, '\0');
  struct Case {
    std::string cameras, images;
    std::vector<std::string> words;
  };
  const Case cases[] = {
      {"", images, {"cameras.bin", "number of cameras"}},
      {with(cameras, 0, many), images, {"cameras.bin", "number of cameras", "room for"}},
      {cameras.substr(0, cameras.size() - 1), images, {"cameras.bin", "camera 7"}},
      {with(cameras, 12, "\5"), images, {"cameras.bin", "camera 7", "OPENCV_FISHEYE", "undistort"}},
      {with(cameras, 12, "\x40"), images, {"cameras.bin", "camera 7", "64"}},
      {with(cameras, 16, many), images, {"cameras.bin", "camera 7", "size"}},
      {with(cameras, 32, nan), images, {"cameras.bin", "camera 7", "finite"}},
      {with(cameras, 32, zeros.substr(0, 8)), images, {"cameras.bin", "camera 7", "focal"}},
      {cameras, "", {"images.bin", "number of images"}},
      {cameras, with(images, 0, many), {"images.bin", "number of images"}},
      {cameras, with(images, 0, std::string(8, '\0')), {"images.bin", "no image"}},
      {cameras, images.substr(0, images.size() - 1), {"images.bin", "points"}},
      {cameras, images.substr(0, 75), {"images.bin", "number of images"}},
      {cameras, with(images, 68, "\1"), {"images.bin", "camera 1", "does not exist"}},
      {cameras, with(images, 12, zeros), {"images.bin", "no pose"}},
      {cameras, with(images, 44, nan), {"images.bin", "no pose"}},
      {cameras, with(images, images.find(".png") + 5, many), {"images.bin", "number of points"}},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(&one - cases);
    folder.file("cameras.bin", one.cameras);
    folder.file("images.bin", one.images);
    expect_error(Failure::kInput, one.words, [&] { read_cameras(folder.path()); });
  }
  const auto read = [&](const fs::path&) { read_cameras(folder.path()); };
  folder.file("cameras.bin", cameras);
  EXPECT_GT(errors_of_damaged(folder, "images.bin", images, 9, read), 5);
  folder.file("images.bin", images);
  EXPECT_GT(errors_of_damaged(folder, "cameras.bin", cameras, 2, read), 10);
}

TEST(Colmap, HostileTextNamesTheLine) {
  const TemporaryFolder folder;
  const std::string cameras = text_cameras(kModels[1]), images = text_images(some_cameras());
  const auto refused = [&](const std::string& c, const std::string& i, const std::vector<std::string>& words) {
    folder.file("cameras.txt", c);
    folder.file("images.txt", i);
    expect_error(Failure::kInput, words, [&] { read_cameras(folder.path()); });
  };
  refused("7 PINHOLE 640", images, {"cameras.txt", "line 1"});
  refused("7 PINHOLE 640 480 1 2 3", images, {"cameras.txt", "line 1", "PINHOLE has 4"});
  refused("7 FOV 640 480 1 2 3 4 5", images, {"cameras.txt", "FOV", "undistort"});
  refused("7 BENT 640 480 1 2 3 4 5", images, {"cameras.txt", "BENT"});
  refused(cameras + "7 PINHOLE 640 480 1 2 3 4\n", images, {"cameras.txt", "camera 7"});
  refused(cameras, "1 2 3", {"images.txt", "line 1"});
  refused(cameras, "# none\n", {"images.txt", "no image"});
  refused(cameras, "1 0 0 0 0 0 0 0 7 a.png\n\n", {"images.txt", "line 1", "no pose"});
  refused(cameras, "1 1 0 0 0 0 0 0 8 a.png\n\n", {"images.txt", "camera 8"});
  // Without the lines of points every second image would be lost.
  refused(cameras, "1 1 0 0 0 0 0 0 7 a.png\n2 1 0 0 0 0 0 0 7 b.png\n",
          {"images.txt", "line 2", "'b.png'", "two lines"});
  refused(cameras, "1 1 0 0 0 0 0 0 7 a\n2 1 0 0 0 0 0 0 7 2\n",
          {"images.txt", "line 2", "inside a point", "two lines"});
  refused(cameras, "1 1 0 0 0 0 0 0 7 a.png\n1.5 2 -1 3 4\n", {"images.txt", "line 2", "inside a point"});
}

TEST(Colmap, ALensThatIsNotReadCountsOnlyWhereAnImageHasIt) {
  const TemporaryFolder folder;
  const std::vector<Camera> cameras = some_cameras();
  std::string text = text_cameras(kModels[1]) + "8 FOV 640 480 1 2 3 4 5\n", bytes = binary_cameras(1, {1, 1, 1, 1});
  folder.file("text/cameras.txt", text);
  folder.file("text/images.txt", text_images(cameras));
  expect_same_views(cameras, read_cameras(folder / "text").cameras);
  bytes[0] = 2;
  put(bytes, uint32_t(8));
  put(bytes, int32_t(5));
  put(bytes, uint64_t(640));
  put(bytes, uint64_t(480));
  for (int k = 0; k < 8; ++k) put(bytes, 1.0);
  folder.file("binary/cameras.bin", bytes);
  folder.file("binary/images.bin", binary_images(cameras));
  expect_same_views(cameras, read_cameras(folder / "binary").cameras);
}

TEST(CamerasJson, RoundTripKeepsTheViewsAndSaysWhatIsLost) {
  const TemporaryFolder folder;
  const std::vector<Camera> cameras = some_cameras();
  EXPECT_EQ(write_cameras(folder / "cameras.json", cameras).size(), 1u);  // the principal point
  const CameraFile file = read_cameras(folder / "cameras.json");
  EXPECT_EQ(file.format, "cameras.json of 3DGS");
  expect_same_views(cameras, file.cameras);
  EXPECT_EQ(file.cameras[0].fy, 510);
  EXPECT_EQ(file.cameras[0].cx, 320);
}

TEST(CamerasJson, PositionAndRotationAreFromCameraToWorld) {
  const TemporaryFolder folder;
  const CameraFile file =
      read_cameras(folder.file("any.json", R"([{"id": 0, "img_name": "a", "width": 10, "height": 8, "fx": 5, "fy": 6,
    "position": [1, 2, 3], "rotation": [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]}])"));
  EXPECT_TRUE(file.cameras[0].centre().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(file.cameras[0].forward().isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(CamerasJson, ViewsOfTrainAndTestMayShareTheirNames) {
  const TemporaryFolder folder;  // 3DGS lists both with the stems of their photos, here without the photos
  const auto entry = [](int id, const std::string& name) {
    return R"({"id": )" + std::to_string(id) + R"(, "img_name": ")" + name +
           R"(", "width": 10, "height": 8, "fx": 5, "fy": 6, "position": [)" + std::to_string(id) +
           R"(, 2, 3], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]})";
  };
  const CameraFile file = read_cameras(
      folder.file("cameras.json", "[" + entry(0, "r_0") + "," + entry(1, "r_1") + "," + entry(2, "r_0") + "]"));
  ASSERT_EQ(file.cameras.size(), 3u);
  const char* names[] = {"r_0", "r_1", "r_0_2"};
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(file.cameras[k].name, names[k]);
    EXPECT_NEAR(file.cameras[k].centre().x(), k, 1e-12);
  }
}

TEST(CamerasJson, HostileEntriesAreNamed) {
  const TemporaryFolder folder;
  write_cameras(folder / "cameras.json", some_cameras());
  const json good = json::parse(read_text(folder / "cameras.json"));
  const auto refused = [&](const std::string& key, const json& value, const std::vector<std::string>& words) {
    json changed = good;
    changed[1][key] = value;
    folder.file("cameras.json", changed.dump());
    expect_error(Failure::kInput, words, [&] { read_cameras(folder / "cameras.json"); });
  };
  refused("fx", -1, {"[1].fx", "positive"});
  refused("width", 1e9, {"[1].width", "range"});
  refused("height", 0, {"[1].height", "range"});
  refused("position", {1, 2}, {"[1].position", "3 numbers"});
  refused("rotation", {{1, 0, 0}, {0, 1, 0}}, {"[1].rotation", "2 rows"});
  refused("rotation", {{1, 0, 0}, {0, 1, 0}, {0, 0, 2}}, {"[1].rotation", "not a rotation"});
  refused("rotation", {{1, 0, 0}, {0, "a", 0}, {0, 0, 1}}, {"[1].rotation", "a"});
  refused("img_name", 7, {"[1].img_name"});
  write_image(folder / "view_0.png", ImageF(640, 480, 3));
  refused("img_name", good[0]["img_name"], {"view_0", "two frames"});
  folder.file("cameras.json", "[]");
  expect_error(Failure::kInput, {"cameras.json", "not an array"}, [&] { read_cameras(folder / "cameras.json"); });
  folder.file("cameras.json", "[1");
  expect_error(Failure::kInput, {"cameras.json", "JSON"}, [&] { read_cameras(folder / "cameras.json"); });
}

std::string par_file(const std::vector<Camera>& cameras) {
  std::string text = std::to_string(cameras.size()) + "\n";
  for (const Camera& camera : cameras) {
    char line[200];
    std::snprintf(line, sizeof line, "%s.png %.9f 0 %.9f 0 %.9f %.9f 0 0 1", camera.name.c_str(), camera.fx, camera.cx,
                  camera.fy, camera.cy);
    text += line;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        std::snprintf(line, sizeof line, " %.17g", camera.cam_from_world.linear()(i, j));
        text += line;
      }
    }
    for (int i = 0; i < 3; ++i) {
      std::snprintf(line, sizeof line, " %.17g", camera.cam_from_world.translation()[i]);
      text += line;
    }
    text += "\n";
  }
  return text;
}

TEST(Middlebury, ViewsAreReadWithTheSizeOfThePhotos) {
  const TemporaryFolder folder;
  const std::vector<Camera> cameras = some_cameras();
  folder.file("thing_par.txt", par_file(cameras));
  EXPECT_EQ(read_cameras(folder / "thing_par.txt").cameras[0].width, 620);  // twice the principal point
  for (const Camera& camera : cameras) write_image(folder / (camera.name + ".png"), ImageF(640, 480, 3));
  const CameraFile file = read_cameras(folder / "thing_par.txt");
  expect_same_views(cameras, file.cameras);
  EXPECT_EQ(file.cameras[0].fy, 510);
  EXPECT_TRUE(file.warnings.empty());
}

TEST(Middlebury, HostileFilesNameTheLine) {
  const TemporaryFolder folder;
  const std::string good = par_file(some_cameras());
  const auto refused = [&](std::string text, const std::vector<std::string>& words) {
    expect_error(Failure::kInput, words, [&] { read_cameras(folder.file("x_par.txt", text)); });
  };
  refused("", {"x_par.txt", "line 1"});
  refused("999999999\n" + good.substr(2), {"line 1", "999999999"});
  refused("-1\n" + good.substr(2), {"line 1"});
  refused("4\n" + good.substr(2), {"line 5", "missing"});
  refused(good.substr(0, good.size() / 2), {"x_par.txt", "line"});
  refused("1\na.png 500 0 1 0 500 1 0 0 1 1 0 0 0 1 0 0 0 5 0 0 0\n", {"line 2", "not a rotation"});
  refused("1\na.png 500 7 1 0 500 1 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n", {"line 2", "skew"});
  refused("1\na.png -5 0 1 0 500 1 0 0 1 1 0 0 0 1 0 0 0 1 0 0 0\n", {"line 2", "focal"});
}

TEST(Colmap, OfSeveralModelsTheFirstOrTheLargestIsTakenAndTheOthersAreNamed) {
  const std::vector<Camera> cameras = some_cameras();
  for (const bool binary : {true, false})
    for (const char* around : {"sparse", "colmap/sparse"}) {
      const TemporaryFolder folder;
      const fs::path models = folder / around;
      const auto write = [&](const std::string& name, int count) {
        const std::vector<Camera> some(cameras.begin(), cameras.begin() + count);
        const std::string model = around + ("/" + name), ending = binary ? ".bin" : ".txt";
        folder.file(model + "/cameras" + ending,
                    binary ? binary_cameras(1, kModels[1].parameters) : text_cameras(kModels[1]));
        folder.file(model + "/images" + ending, binary ? binary_images(some) : text_images(some));
      };
      write("0", 1);
      EXPECT_EQ(cameras_in(folder.path(), ColmapChoice::kLargest), models / "0");
      EXPECT_EQ(other_models(models / "0"), "");
      write("2", 3);
      write("10", 3);
      write("0_rotated", 3);
      EXPECT_EQ(cameras_in(folder.path()), models / "0");
      EXPECT_EQ(cameras_in(folder.path(), ColmapChoice::kLargest), models / "2");
      const CameraFile file = read_cameras(folder.path());
      EXPECT_EQ(file.cameras.size(), 1u);
      EXPECT_NE(file.warnings.back().find("sparse/0 with 1 images is used; sparse/2 has 3, sparse/10 has 3"),
                std::string::npos)
          << file.warnings.back();
      EXPECT_NE(other_models(models / "2" / "").find("sparse/2 with 3 images is used; sparse/0 has 1"),
                std::string::npos);
      EXPECT_TRUE(other_models(folder.path()).empty());
      if (!binary) continue;
      // A count that the file cannot hold is not believed.
      folder.file(around + std::string("/10/images.bin"), std::string(8, '\x7f'));
      EXPECT_EQ(cameras_in(folder.path(), ColmapChoice::kLargest), models / "2");
      fs::remove_all(models / "0");
      EXPECT_EQ(cameras_in(folder.path()), models / "2");
    }
}

TEST(Scene, FindsCamerasBesideAndAroundItsSplats) {
  const TemporaryFolder folder;
  const std::vector<Camera> cameras = some_cameras();
  write_ply(folder / "model/point_cloud/iteration_7/point_cloud.ply", some_gaussians(200, 0));
  EXPECT_TRUE(load_scene(folder / "model").cameras_are_orbit);
  folder.file("model/sparse/0/cameras.txt", text_cameras(kModels[1]));
  folder.file("model/sparse/0/images.txt", text_images(cameras));
  for (const char* path : {"model", "model/point_cloud/iteration_7/point_cloud.ply"}) {
    expect_same_views(cameras, load_scene(folder / path).cameras);
  }
  const fs::path before = fs::current_path();
  fs::current_path(folder / "model/point_cloud/iteration_7");
  expect_same_views(cameras, load_scene("point_cloud.ply").cameras);
  expect_same_views(cameras, load_scene("../iteration_7/point_cloud.ply").cameras);
  fs::current_path(before);
  EXPECT_EQ(json(load_scene(folder / "model").warnings).dump().find("sparse/1"), std::string::npos);
  folder.file("model/sparse/1/cameras.txt", text_cameras(kModels[1]));
  folder.file("model/sparse/1/images.txt", text_images(cameras));
  EXPECT_NE(json(load_scene(folder / "model").warnings).dump().find("sparse/1 has 3"), std::string::npos);
  write_cameras(folder / "model/cameras.json", {cameras[0]});
  EXPECT_EQ(load_scene(folder / "model").cameras.size(), 1u);
  EXPECT_EQ(describe(folder / "model")["cameras"]["count"], 1);
  EXPECT_EQ(describe(folder / "model/sparse/0")["cameras"]["format"], "COLMAP text");
}

/// What `ns-export cameras` writes.
const char* const kPoseList = R"([{"file_path": "a.jpg", "transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}])";

TEST(Scene, PosesWithoutIntrinsicsBesideSplatsArePassedOver) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", some_gaussians(200, 0));
  for (const char* name : {"transforms_train.json", "transforms_eval.json"}) folder.file(name, kPoseList);
  EXPECT_TRUE(load_scene(folder / "a.ply").cameras_are_orbit);
  EXPECT_TRUE(load_scene(folder.path()).cameras_are_orbit);
  expect_error(Failure::kInput, {"transforms_train.json", "without intrinsics", "ns-export"},
               [&] { read_cameras(folder / "transforms_train.json"); });
  write_cameras(folder / "cameras.json", some_cameras());
  EXPECT_EQ(load_scene(folder / "a.ply").cameras.size(), some_cameras().size());
}

TEST(Scene, CamerasFoundBesideSplatsOfNerfstudioAreDoubted) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", some_gaussians(200, 0));
  const std::string plain = read_text(folder / "a.ply");
  std::string marked = plain;
  marked.insert(marked.find("element"), "comment Generated by Nerstudio 1.1.5\n");
  const auto doubted = [&](const fs::path& source) {
    return json(load_scene(source).warnings).dump().find("folder without cameras") != std::string::npos;
  };
  folder.file("a.ply", marked);
  EXPECT_FALSE(doubted(folder / "a.ply")) << "without cameras";
  write_cameras(folder / "transforms.json", some_cameras());
  EXPECT_TRUE(doubted(folder / "a.ply"));
  EXPECT_TRUE(doubted(folder.path()));
  folder.file("scene.json", R"({"splats": "a.ply"})");
  EXPECT_TRUE(doubted(folder.path()));
  folder.file("scene.json", R"({"splats": "a.ply", "cameras": "transforms.json"})");
  EXPECT_FALSE(doubted(folder.path())) << "named by the user";
  folder.file("a.ply", plain);
  EXPECT_FALSE(doubted(folder / "a.ply"));
}

TEST(Scene, OfAFolderWithOneSplatFileIsThatFile) {
  const TemporaryFolder folder;
  write_ply(folder / "a.ply", some_gaussians(200, 0));
  folder.file("readme.txt", "hello");
  EXPECT_EQ(load_scene(folder.path()).cloud.size(), 200u);
  // Neither point clouds nor archives beside it are scenes.
  const std::string points =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n0 0 0\n";
  folder.file("sparse_pc.ply", points);
  folder.file("ckpt_29999.pt", "PK\3\4");
  for (const char* name : {"poses.csv.gz", "b.tgz"}) folder.file(name, "\x1f\x8b");
  for (const char* name : {"scan.usdz", "a.ZIP", "project.psz"}) folder.file(name, "PK\3\4");
  EXPECT_EQ(splats_of_folder(folder.path()), folder / "a.ply");
  EXPECT_TRUE(is_point_cloud(folder / "sparse_pc.ply"));
  write_ply(folder / "b.ply", some_gaussians(100, 0));
  expect_error(Failure::kInput, {"several splat files: a.ply, b.ply", "one of them"},
               [&] { load_scene(folder.path()); });
}

}  // namespace
}  // namespace pliant
