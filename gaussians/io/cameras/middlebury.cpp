#include "gaussians/io/cameras/middlebury.h"

#include <cmath>
#include <sstream>

#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

constexpr size_t kShortestLine = 2 + 2 * 21;  // a name and 21 numbers

Camera camera_of(const double* v, const std::string& file, const std::string& field) {
  const auto refuse = [&](const std::string& problem) {
    return input_error(file, field, problem, "it must be: name, K (9 numbers), R (9), t (3)");
  };
  for (int k = 0; k < 21; ++k) {
    if (!std::isfinite(v[k])) throw refuse("holds values that are not finite");
  }
  if (v[6] != 0 || v[7] != 0 || v[8] != 1 || v[3] != 0 || std::abs(v[1]) > 1e-6 * std::abs(v[0]))
    throw refuse("has a K with skew or of another kind");
  if (!(v[0] > 0 && v[4] > 0)) throw refuse("has the focal length " + std::to_string(std::min(v[0], v[4])));
  Camera camera;
  camera.fx = v[0];
  camera.cx = v[2];
  camera.fy = v[4];
  camera.cy = v[5];
  Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v + 9);
  if (!make_rotation(rotation)) throw refuse("has an R that is not a rotation");
  camera.cam_from_world.linear() = rotation;
  camera.cam_from_world.translation() = Eigen::Vector3d(v[18], v[19], v[20]);
  return camera;
}

}  // namespace

CameraFile read_middlebury(const fs::path& file, const fs::path& photos, PhotoFit fit) {
  const std::string text = read_text(file), name = file.string();
  std::istringstream in(text);
  std::string line;
  std::getline(in, line);
  std::istringstream first(line);
  long long count = -1;
  if (!(first >> count) || count < 1 || static_cast<uint64_t>(count) > text.size() / kShortestLine) {
    throw input_error(name, "line 1", "is '" + line.substr(0, 60) + "'", "it must be the number of lines that follow");
  }
  CameraCollector collector(file, fit);
  int width = 0, height = 0;
  std::vector<std::pair<Camera, std::string>> frames;
  for (long long i = 0; i < count; ++i) {
    const std::string field = "line " + std::to_string(i + 2);
    if (!std::getline(in, line))
      throw input_error(name, field, "is missing", "line 1 declares " + std::to_string(count) + " photos");
    std::istringstream words(line);
    std::string photo;
    double values[21];
    words >> photo;
    for (double& value : values) words >> value;
    if (!words)
      throw input_error(name, field, "is '" + line.substr(0, 60) + "'",
                        "it must be: name, K (9 numbers), R (9), t (3)");
    Camera camera = camera_of(values, name, field);
    camera.photo = find_photo(photos, {file.parent_path(), file.parent_path() / "images"}, photo, fit).string();
    if (width == 0 && !camera.photo.empty()) read_photo_size(camera.photo, fit, width, height);
    frames.emplace_back(std::move(camera), photo);
  }
  for (auto& [camera, photo] : frames) {
    camera.width = width > 0 ? width : static_cast<int>(std::lround(std::clamp(2 * camera.cx, 1.0, 65536.0)));
    camera.height = width > 0 ? height : static_cast<int>(std::lround(std::clamp(2 * camera.cy, 1.0, 65536.0)));
    collector.add(std::move(camera), photo);
  }
  return collector.finish("Middlebury _par.txt", width > 0);
}

}  // namespace pliant
