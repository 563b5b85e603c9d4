#include <gtest/gtest.h>

#include "gaussians/base/error.h"
#include "gaussians/base/types.h"
#include "gaussians/io/cameras/cameras.h"
#include "gaussians/io/cameras/llff.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/images/image_io.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// A plain NumPy array of doubles; `shape` is what stands in its brackets.
std::string npy(const std::vector<double>& values, const std::string& shape, const std::string& fortran = "False") {
  std::string header = "{'descr': '<f8', 'fortran_order': " + fortran + ", 'shape': (" + shape + "), }";
  while ((10 + header.size() + 1) % 64) header += ' ';
  header += '\n';
  std::string out = "\x93NUMPY";
  out += {'\1', '\0', static_cast<char>(header.size() & 255), static_cast<char>(header.size() >> 8)};
  out += header;
  out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
  return out;
}

std::vector<Camera> three_cameras() {
  std::vector<Camera> cameras;
  for (int k = 0; k < 3; ++k)
    cameras.push_back(look_at({0.3 * k - 0.2, -2.0, 0.4}, {0.1, 0, 0.2}, {0, 0, 1}, 64, 48, 70));
  return cameras;
}

/// What LLFF stores of them: the axes down, right and back.
std::vector<double> rows_of(const std::vector<Camera>& cameras) {
  std::vector<double> rows;
  for (const Camera& camera : cameras) {
    const Mat3d axes = camera.cam_from_world.linear().transpose();  // right, down, forward in the world
    const Vec3d centre = camera.centre(), size(camera.height, camera.width, camera.fx);
    for (int r = 0; r < 3; ++r) rows.insert(rows.end(), {axes(r, 1), axes(r, 0), -axes(r, 2), centre[r], size[r]});
    rows.insert(rows.end(), {1.0, 9.0});
  }
  return rows;
}

class Llff : public ::testing::Test {
 protected:
  void SetUp() override { write(npy(rows_of(cameras), "3, 17")); }
  void write(const std::string& bytes) { write_text(file, bytes); }
  void photos(const char* name, int count, int scale) {
    fs::create_directories(folder / name);
    for (int k = 0; k < count; ++k)
      write_image(folder / name / ("p" + std::to_string(k) + ".png"), ImageF(64 / scale, 48 / scale, 3, 0.5f));
  }
  TemporaryFolder folder;
  fs::path file = folder / "poses_bounds.npy";
  std::vector<Camera> cameras = three_cameras();
};

TEST_F(Llff, PosesAreThoseThatWereStoredAndFollowTheScaledPhotos) {
  photos("images_4", 3, 4);
  const CameraFile read = read_cameras(folder.path());
  EXPECT_EQ(read.format, "LLFF poses_bounds.npy");
  ASSERT_EQ(read.cameras.size(), 3u);
  EXPECT_EQ(read.photos_found, 3);
  for (int k = 0; k < 3; ++k) {
    const Camera& camera = read.cameras[k];
    EXPECT_EQ(camera.name, "p" + std::to_string(k));
    EXPECT_LE((camera.cam_from_world.matrix() - cameras[k].cam_from_world.matrix()).norm(), 1e-12);
    EXPECT_EQ(camera.width, 16);
    EXPECT_EQ(camera.height, 12);
    EXPECT_NEAR(camera.fx, 70.0 / 4, 1e-12);
    EXPECT_NEAR(camera.cx, 8, 1e-12);
  }
}

TEST_F(Llff, FullPhotosComeBeforeScaledOnesAndWithoutAnyThePosesStand) {
  EXPECT_EQ(read_llff(file).cameras[2].width, 64);
  EXPECT_EQ(read_llff(file).photos_found, 0);
  photos("images_8", 3, 8);
  photos("images", 3, 1);
  EXPECT_EQ(read_llff(file).cameras[0].width, 64);
  EXPECT_EQ(read_llff(file, folder / "images_8").cameras[0].width, 8);
}

TEST_F(Llff, APictureBesideTheFileIsNoPhotoOfIt) {
  photos("images", 3, 1);
  photos("", 1, 2);
  EXPECT_EQ(read_llff(file, folder.path()).photos_found, 3);
  fs::remove_all(folder / "images");
  expect_error(Failure::kInput, {"3 rows", "1 photos"}, [&] { read_llff(file, folder.path()); });
}

TEST_F(Llff, OtherNumbersOfPhotosAndDamagedFilesAreRefusedByRow) {
  const std::string whole = npy(rows_of(cameras), "3, 17");
  const auto refused = [&](const std::string& bytes, const std::vector<std::string>& words) {
    write(bytes);
    expect_error(Failure::kInput, words, [&] { read_llff(file); });
  };
  refused(npy(rows_of(cameras), "51"), {"poses_bounds.npy", "shape"});
  refused(npy(rows_of(cameras), "17, 3"), {"shape"});
  refused(npy(rows_of(cameras), "3, 17", "True"), {"fortran_order"});
  refused(npy(rows_of(cameras), "4000000000, 17"), {"shape"});
  refused(npy(rows_of(cameras), "4, 17"), {"cut off"});
  refused(npy({}, ""), {"cut off"});
  refused(npy({1}, ""), {"shape"});
  for (const size_t length : {size_t{0}, size_t{9}, size_t{60}, whole.size() - 1})
    refused(whole.substr(0, length), {"poses_bounds"});
  for (const auto& [at, value, word] : std::vector<std::tuple<size_t, double, std::string>>{
           {17 + 2, NAN, "row 1"}, {17 + 14, -1, "focal"}, {4, 1e9, "size"}, {0, 3, "rotation"}}) {
    std::vector<double> rows = rows_of(cameras);
    rows[at] = value;
    refused(npy(rows, "3, 17"), {word});
  }
  write(whole);
  photos("images", 2, 1);
  expect_error(Failure::kInput, {"3 rows", "2 photos"}, [&] { read_llff(file); });
}

}  // namespace
}  // namespace pliant
