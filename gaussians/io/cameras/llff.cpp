#include "gaussians/io/cameras/llff.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/npy.h"
#include "gaussians/io/files/paths.h"
#include "gaussians/io/images/image_files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr size_t kRow = 17;  // [3, 5] and two bounds
const char* const kForm = "each row must be [R | t | (height, width, focal length)] and two bounds, 17 numbers";

/// The photos that the rows belong to; none where there is no folder of them.
std::vector<fs::path> photos_of(const fs::path& file, const fs::path& photos, size_t rows) {
  const fs::path beside = file.parent_path();
  std::vector<fs::path> folders = {photos};
  for (const char* name : {"images", "images_2", "images_4", "images_8"}) folders.push_back(beside / name);
  std::error_code ignored;
  if (fs::equivalent(photos, beside, ignored)) std::rotate(folders.begin(), folders.begin() + 1, folders.end());
  std::optional<Error> mismatch;
  for (const fs::path& folder : folders) {
    if (folder.empty()) continue;
    const std::vector<fs::path> found = images_in(folder);
    if (found.empty()) continue;
    if (found.size() == rows) return found;
    if (!mismatch)
      mismatch = input_error(file.string(), "",
                             "has " + std::to_string(rows) + " rows, but " + folder.string() + " has " +
                                 std::to_string(found.size()) + " photos",
                             "keep exactly the photos that the poses were made for");
  }
  if (mismatch) throw *mismatch;
  return {};
}

Camera camera_of(const double* v, const std::string& file, size_t row) {
  const auto refuse = [&](const std::string& problem) {
    return input_error(file, "row " + std::to_string(row), problem, kForm);
  };
  for (size_t k = 0; k < kRow; ++k)
    if (!std::isfinite(v[k])) throw refuse("holds values that are not finite");
  const double height = v[4], width = v[9], focal = v[14];
  if (!(height >= 1 && width >= 1 && height <= 65536 && width <= 65536 && focal > 0))
    throw refuse("has the size " + std::to_string(width) + " x " + std::to_string(height) + " and the focal length " +
                 std::to_string(focal));
  const auto column = [&](int k) { return Eigen::Vector3d(v[k], v[5 + k], v[10 + k]); };
  Eigen::Matrix4d world_from_cam = Eigen::Matrix4d::Identity();  // axes of OpenGL: right, up, back
  world_from_cam.topRows<3>() << column(1), -column(0), column(2), column(3);
  Camera camera;
  if (const char* wrong = cam_from_opengl(world_from_cam, camera.cam_from_world)) throw refuse(wrong);
  camera.width = static_cast<int>(std::lround(width));
  camera.height = static_cast<int>(std::lround(height));
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  return camera;
}

}  // namespace

CameraFile read_llff(const fs::path& file, const fs::path& photos, PhotoFit fit) {
  const std::string name = file.string();
  const NpyArray array = read_npy_array(read_text(file), name);
  if (array.shape.size() != 2 || array.shape[1] != kRow)
    throw input_error(name, "shape",
                      "has " + std::to_string(array.values.size()) + " numbers in " +
                          std::to_string(array.shape.size()) + " dimensions",
                      kForm);
  const std::vector<fs::path> found = photos_of(file, photos, array.shape[0]);
  CameraCollector collector(file, fit);
  for (size_t i = 0; i < array.shape[0]; ++i) {
    Camera camera = camera_of(array.values.data() + kRow * i, name, i);
    if (!found.empty()) camera.photo = tidy_path(found[i]).string();
    collector.add(std::move(camera), found.empty() ? "image" + std::to_string(i) : found[i].filename().string());
  }
  return collector.finish("LLFF poses_bounds.npy");
}

}  // namespace pliant
