// Points of structure from motion: COLMAP binary and text, the point cloud of transforms.json, and damaged files.

#include "gaussians/io/cameras/sparse_points.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gaussians/base/lens.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/ply_points.h"
#include "gaussians/io/cameras/transforms.h"
#include "tests/gaussians/format_files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

const Lens kLens = {0.1, -0.05, 0.001, -0.002, 0, 0};
const Vec3d kPoints[] = {{0.1, 0.2, 0.3}, {-0.2, 0.1, 0}, {0.3, -0.3, 0.1}};

/// A COLMAP model of two photos of three points; the first photo sees all, the second the first two.
class Model {
 public:
  Model() {
    for (int i = 0; i < 2; ++i) {
      cameras_.push_back(look_at({i - 0.5, 0.3, -3}, {0, 0, 0}, {0, -1, 0}, 640, 480, 500));
      cameras_.back().distortion = kLens;
      cameras_.back().name = i == 0 ? "left" : "right";
    }
  }

  void write(const TemporaryFolder& folder, bool binary) const {
    const std::string ending = binary ? ".bin" : ".txt";
    folder.file("cameras" + ending, binary ? binary_camera() : text_camera());
    folder.file("images" + ending, binary ? binary_images() : text_images());
    folder.file("points3D" + ending, binary ? binary_points() : text_points());
  }

  std::string binary_points() const {
    std::string bytes;
    put(bytes, uint64_t(3));
    for (uint32_t p = 0; p < 3; ++p) {
      put(bytes, uint64_t(100 + p));
      for (const double value : kPoints[p]) put(bytes, value);
      bytes += {char(51), char(102), char(255)};
      put(bytes, 0.5);
      put(bytes, uint64_t(p < 2 ? 2 : 1));
      put(bytes, uint32_t(7));
      put(bytes, p);
      if (p < 2) {
        put(bytes, uint32_t(9));
        put(bytes, p);
      }
    }
    return bytes;
  }

  std::string text_points() const {
    std::string text = "# 3D point list\n";
    for (int p = 0; p < 3; ++p) {
      text += std::to_string(100 + p);
      for (const double value : kPoints[p]) text.append(" ").append(std::to_string(value));
      text += " 51 102 255 0.5 7 " + std::to_string(p) + (p < 2 ? " 9 " + std::to_string(p) : "") + "\n";
    }
    return text;
  }

  std::vector<Camera> cameras_;
  std::string photos_[2] = {"folder/left.jpg", "folder/right.jpg"};

 private:
  static std::string binary_camera() {
    std::string bytes;
    put(bytes, uint64_t(1));
    put(bytes, uint32_t(1));
    put(bytes, int32_t(4));
    put(bytes, uint64_t(640));
    put(bytes, uint64_t(480));
    for (const double value : {500.0, 500.0, 320.0, 240.0, kLens[0], kLens[1], kLens[2], kLens[3]}) put(bytes, value);
    return bytes;
  }
  static std::string text_camera() { return "1 OPENCV 640 480 500 500 320 240 0.1 -0.05 0.001 -0.002\n"; }

  template <class Number, class Image, class Feature>
  void images(Number&& number, Image&& image, Feature&& feature) const {
    for (int i = 0; i < 2; ++i) {
      const Eigen::Quaterniond q(cameras_[i].cam_from_world.linear());
      const Vec3d t = cameras_[i].cam_from_world.translation();
      image(i);
      for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) number(value);
      feature(i, -1, Eigen::Vector2d());
      for (int p = 0; p < 3 - i; ++p) feature(i, p, *project(cameras_[i], kPoints[p]));
    }
  }
  std::string binary_images() const {
    std::string bytes;
    put(bytes, uint64_t(2));
    images([&](double value) { put(bytes, value); }, [&](int i) { put(bytes, uint32_t(i == 0 ? 7 : 9)); },
           [&](int i, int p, const Eigen::Vector2d& x) {
             if (p >= 0) return put(bytes, x.x()), put(bytes, x.y()), put(bytes, int64_t(100 + p));
             put(bytes, uint32_t(1));
             bytes += photos_[i] + '\0';
             put(bytes, uint64_t(3 - i));
           });
    return bytes;
  }
  std::string text_images() const {
    std::string text;
    images([&](double value) { text.append(" ").append(std::to_string(value)); },
           [&](int i) { text += i == 0 ? "7" : "\n9"; },
           [&](int i, int p, const Eigen::Vector2d& x) {
             if (p < 0)
               text.append(" 1 ").append(photos_[i]).append("\n");
             else
               text += std::to_string(x.x()) + " " + std::to_string(x.y()) + " " + std::to_string(100 + p) + " ";
           });
    return text + "\n";
  }
};

double worst_reprojection(const SparsePoints& points, const std::vector<Camera>& cameras) {
  double worst = 0;
  for (const auto& [point, camera, pixel] : points.observations) {
    worst = std::max(worst,
                     (*project(cameras[camera], points.position[point].cast<double>()) - pixel.cast<double>()).norm());
  }
  return worst;
}

TEST(SparsePoints, OfColmapComeWithTracksFromBinaryAndText) {
  for (const bool binary : {true, false}) {
    const TemporaryFolder folder;
    const Model model;
    model.write(folder, binary);
    const std::vector<Camera> cameras = read_cameras(folder.path()).cameras;
    const SparsePoints points = read_sparse_points(folder.path(), cameras);
    ASSERT_EQ(points.position.size(), 3u);
    for (int p = 0; p < 3; ++p) EXPECT_NEAR((points.position[p].cast<double>() - kPoints[p]).norm(), 0, 1e-6);
    EXPECT_NEAR((points.color[1] - Vec3f(0.2f, 0.4f, 1)).norm(), 0, 1e-6);
    ASSERT_EQ(points.observations.size(), 5u);
    EXPECT_EQ(points.observations[3].point, 1);
    EXPECT_EQ(points.observations[3].camera, 1);
    EXPECT_LT(worst_reprojection(points, cameras), 2e-3);
    EXPECT_NE(points.source.find("3 points of"), std::string::npos);
  }
}

TEST(SparsePoints, ObservationsFollowCamerasThatWereReorderedScaledOrUndistorted) {
  const TemporaryFolder folder;
  Model model;
  model.write(folder, true);
  std::vector<Camera> cameras = {model.cameras_[1].scaled(0.25), model.cameras_[0]};
  cameras[1].distortion = {};
  cameras[1].cx -= 11;
  const SparsePoints points = read_sparse_points(folder.path(), cameras);
  EXPECT_EQ(points.observations.size(), 5u);
  EXPECT_LT(worst_reprojection(points, cameras), 1e-3);
  // Photos that are not there have no observations.
  cameras[0].name = "another";
  EXPECT_EQ(read_sparse_points(folder.path(), cameras).observations.size(), 3u);
}

TEST(SparsePoints, ObservationsOfAPhotoThatIsNotThereAreNotThoseOfOneWithItsStem) {
  for (const char* separator : {"/", "\\"}) {
    const TemporaryFolder folder;
    Model model;
    model.photos_[0] = std::string("cam1") + separator + "0001.jpg";
    model.photos_[1] = std::string("cam2") + separator + "0001.jpg";
    model.write(folder, true);
    Camera camera = model.cameras_[1];
    camera.name = "0001";
    camera.photo = "images/cam2/0001.jpg";
    const SparsePoints points = read_sparse_points(folder.path(), {camera});
    EXPECT_EQ(points.observations.size(), 2u);
    EXPECT_LT(worst_reprojection(points, {camera}), 1e-3);
    camera.photo = "images/my_cam2/0001.jpg";
    EXPECT_TRUE(read_sparse_points(folder.path(), {camera}).observations.empty());
  }
}

TEST(SparsePoints, TheirFileIsFoundWithoutBeingRead) {
  const TemporaryFolder folder;
  Model().write(folder, true);
  folder.file("points3D.bin", "damaged");
  EXPECT_EQ(sparse_points_file(folder.path()), folder / "points3D.bin");
  fs::remove(folder / "points3D.bin");
  EXPECT_TRUE(sparse_points_file(folder.path()).empty());
}

TEST(SparsePoints, DamagedBinaryFilesAreNamed) {
  const TemporaryFolder folder;
  const Model model;
  model.write(folder, true);
  const std::string good = model.binary_points();
  const auto with = [](std::string bytes, size_t at, const std::string& change) {
    return bytes.replace(at, change.size(), change);
  };
  std::string nan;
  put(nan, double(NAN));
  const std::string many(8, '\x7f');
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {"", {"points3D.bin", "number of points"}},
      {with(good, 0, many), {"number of points", "room for"}},
      {with(good, 24, nan), {"point 100", "not finite"}},
      {with(good, 51, many), {"point 100", "length of the track", "room for"}},
      {good.substr(0, good.size() - 1), {"point 102", "track"}},
  };
  for (const auto& [bytes, words] : cases) {
    SCOPED_TRACE(words.back());
    folder.file("points3D.bin", bytes);
    expect_error(Failure::kInput, words, [&] { read_sparse_points(folder.path(), model.cameras_); });
  }
  const auto read = [&](const fs::path&) { read_sparse_points(folder.path(), model.cameras_); };
  EXPECT_GT(errors_of_damaged(folder, "points3D.bin", good, 3, read), 10);
}

TEST(SparsePoints, ObservationsThatMatchNoImageAreLeftOutAndCounted) {
  const Model model;
  std::string no_image = model.binary_points(), no_feature = no_image;
  no_image[59] = 1;
  no_feature[63] = 7;
  const std::pair<std::string, std::vector<std::string>> binary[] = {
      {no_image, {"points3D.bin: 1 of 5 observations", "point 100", "image 1, which does not exist"}},
      {no_feature, {"points3D.bin: 1 of 5 observations", "point 100", "feature 7", "image 7", "has 3"}}};
  const std::pair<std::string, std::vector<std::string>> text[] = {
      {"100 1 2 3 4 5 6 0.5 7 0 8 0 9 2 9 3\n", {"points3D.txt: 3 of 4 observations", "line 1", "image 8"}},
      {"100 1 2 3 4 5 6 0.5 9 2\n", {"points3D.txt: 1 of 1 observations", "line 1", "feature 2", "has 2"}}};
  for (const bool is_binary : {true, false}) {
    const TemporaryFolder folder;
    model.write(folder, is_binary);
    for (const auto& [bytes, words] : is_binary ? binary : text) {
      folder.file(is_binary ? "points3D.bin" : "points3D.txt", bytes);
      const SparsePoints points = read_sparse_points(folder.path(), model.cameras_);
      EXPECT_EQ(points.position.size(), is_binary ? 3u : 1u);
      EXPECT_EQ(points.observations.size(), is_binary ? 4u : words[0].find("3 of 4") != std::string::npos ? 1u : 0u);
      ASSERT_EQ(points.warnings.size(), 1u);
      for (const std::string& word : words)
        EXPECT_NE(points.warnings[0].find(word), std::string::npos) << word << " in " << points.warnings[0];
    }
    model.write(folder, is_binary);
    EXPECT_TRUE(read_sparse_points(folder.path(), model.cameras_).warnings.empty());
  }
}

TEST(SparsePoints, DamagedTextFilesNameTheLine) {
  const TemporaryFolder folder;
  const Model model;
  model.write(folder, false);
  const std::pair<std::string, std::vector<std::string>> cases[] = {
      {"100 1 2 3 4 5", {"points3D.txt", "line 1"}},
      {"100 1 2 nan 4 5 6 0.5", {"points3D.txt", "line 1"}},
      {"\n100 1 2 3 4 5 6 0.5 7", {"line 2", "inside a track"}},
      {"100 1 2 3 4 5 6 0.5 7 0 x", {"line 1", "not numbers"}},
  };
  for (const auto& [text, words] : cases) {
    SCOPED_TRACE(text);
    folder.file("points3D.txt", text);
    expect_error(Failure::kInput, words, [&] { read_sparse_points(folder.path(), model.cameras_); });
  }
}

TEST(SparsePoints, AreWrittenBesideTransformsWhichNameThem) {
  const TemporaryFolder folder;
  const Model model;
  SparsePoints points;
  points.position = {Vec3f(1, -2, 3.5f), Vec3f(0, 1e-3f, 9)};
  points.color = {Vec3f(1, 0, 0.2f), Vec3f(0.4f, 0.6f, 0.8f)};
  points.source = "2 points";
  EXPECT_TRUE(write_cameras(folder / "t.json", model.cameras_, points).empty());
  const SparsePoints back = read_sparse_points(folder / "t.json", model.cameras_);
  EXPECT_EQ(back.position, points.position);
  EXPECT_EQ(back.file, folder / "t_points.ply");
  for (size_t i = 0; i < 2; ++i) EXPECT_LT((back.color[i] - points.color[i]).norm(), 1e-6f);
  EXPECT_TRUE(write_cameras(folder / "t.json", model.cameras_).empty());
  EXPECT_TRUE(read_sparse_points(folder / "t.json", model.cameras_).empty());
  const std::vector<std::string> lost = write_cameras(folder / "cameras.json", model.cameras_, points);
  EXPECT_NE(lost.at(0).find("2 points are left out"), std::string::npos);
}

TEST(SparsePoints, OfTransformsAreThePlyThatItNames) {
  const TemporaryFolder folder;
  const Model model;
  write_transforms(folder / "transforms.json", model.cameras_);
  SparsePoints points = read_sparse_points(folder.path(), model.cameras_);
  EXPECT_TRUE(points.empty());
  EXPECT_NE(points.source.find("without points"), std::string::npos);
  nlohmann::json json = nlohmann::json::parse(std::ifstream(folder / "transforms.json"));
  json["ply_file_path"] = "sparse.ply";
  folder.file("transforms.json", json.dump());
  EXPECT_NE(read_sparse_points(folder.path(), model.cameras_).source.find("sparse.ply, which do not exist"),
            std::string::npos);
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  folder.file("sparse.ply", header + "1 2 3 255 0 51\n4 5 6 0 255 0\n");
  points = read_sparse_points(folder / "transforms.json", model.cameras_);
  ASSERT_EQ(points.position.size(), 2u);
  EXPECT_EQ(points.position[1], Vec3f(4, 5, 6));
  EXPECT_NEAR((points.color[0] - Vec3f(1, 0, 0.2f)).norm(), 0, 1e-6);
  EXPECT_TRUE(points.observations.empty());
  for (const auto& [bytes, word] : std::vector<std::pair<std::string, std::string>>{
           {header + "1 2 3 255 0 51\n4 5", "truncated"},
           {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "property y"}}) {
    folder.file("sparse.ply", bytes);
    expect_error(Failure::kInput, {"sparse.ply", word}, [&] { read_sparse_points(folder.path(), model.cameras_); });
  }
}

/// The points of a PLY with colors of this type.
SparsePoints points_of_ply(const TemporaryFolder& folder, const std::string& type, const std::string& rows, int count) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) + "\n";
  for (const char* name : {"x", "y", "z"}) text += std::string("property float ") + name + "\n";
  for (const char* name : {"red", "green", "blue"}) text += "property " + type + " " + name + "\n";
  return read_ply_points(folder.file("p.ply", text + "end_header\n" + rows));
}

TEST(SparsePoints, ColorsOfEveryTypeAreTheSame) {
  const TemporaryFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"uchar", "51 255 0"}, {"ushort", "51 255 0"}, {"int", "51 255 0"},       {"ushort", "13107 65535 0"},
      {"float", "0.2 1 0"},  {"float", "51 255 0"},  {"double", "51.0 255.0 0"}};
  for (const auto& [type, color] : cases) {
    const SparsePoints points = points_of_ply(folder, type, std::string("1 2 3 ") + color + "\n", 1);
    EXPECT_LT((points.color.at(0) - Vec3f(0.2f, 1, 0)).norm(), 1e-6f) << type << " " << color;
  }
}

TEST(SparsePoints, OfAPlyThatAreNotFiniteAreLeftOutAndCounted) {
  const TemporaryFolder folder;
  const SparsePoints points = points_of_ply(folder, "uchar", "1 2 nan 255 0 51\n4 5 6 0 255 0\n", 2);
  ASSERT_EQ(points.position.size(), 1u);
  EXPECT_EQ(points.position[0], Vec3f(4, 5, 6));
  EXPECT_EQ(points.color[0], Vec3f(0, 1, 0));
  ASSERT_EQ(points.warnings.size(), 1u);
  EXPECT_NE(points.warnings[0].find("1 of 2 points"), std::string::npos);
}

TEST(SparsePoints, ThePathOfThePlyMayBeThatOfWindows) {
  const TemporaryFolder folder;
  points_of_ply(folder, "uchar", "1 2 3 0 0 0\n", 1);
  std::filesystem::create_directories(folder / "sparse");
  std::filesystem::rename(folder / "p.ply", folder / "sparse/p.ply");
  write_transforms(folder / "transforms.json", Model().cameras_, folder / "sparse/p.ply");
  nlohmann::json json = nlohmann::json::parse(std::ifstream(folder / "transforms.json"));
  json["ply_file_path"] = ".\\sparse\\p.ply";
  folder.file("transforms.json", json.dump());
  EXPECT_EQ(read_sparse_points(folder.path(), Model().cameras_).position.size(), 1u);
}

TEST(SparsePoints, ObservationsOfPhotosThatDifferByTheirSuffixAreTheirOwn) {
  const TemporaryFolder folder;
  Model model;
  model.photos_[0] = "shots/a.jpg";
  model.photos_[1] = "shots/a.png";
  model.write(folder, true);
  std::vector<Camera> cameras = read_cameras(folder.path()).cameras;
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(cameras[1].name, "shots_a_png");
  const SparsePoints points = read_sparse_points(folder.path(), cameras);
  EXPECT_EQ(points.observations.size(), 5u);
  EXPECT_LT(worst_reprojection(points, cameras), 2e-3);
  // Of the two one alone is there.
  Camera camera = cameras[1];
  camera.name = "a";
  camera.photo = "images/shots/a.png";
  const SparsePoints alone = read_sparse_points(folder.path(), {camera});
  EXPECT_EQ(alone.observations.size(), 2u);
  EXPECT_LT(worst_reprojection(alone, {camera}), 2e-3);
}

}  // namespace
}  // namespace pliant
