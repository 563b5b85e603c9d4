#include "gaussians/io/cameras/cameras.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/colmap.h"
#include "gaussians/io/cameras/llff.h"
#include "gaussians/io/cameras/middlebury.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;

namespace pliant {
namespace {

enum class Format { kNone, kTransforms, kCamerasJson, kColmap, kMiddlebury, kLlff };

bool is_par_file(const fs::path& path) {
  const std::string name = path.filename().string(), ending = "_par.txt";
  return name.size() > ending.size() && name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

bool is_transforms_name(const fs::path& path) {
  return path.filename().string().rfind("transforms", 0) == 0 && path.extension() == ".json";
}

Format format_of_json(const fs::path& file) {
  try {
    const nlohmann::json json = read_json(file);
    if (json.is_array()) return Format::kCamerasJson;
    // A scene.json and other objects are no cameras.
    return json.contains("frames") || is_transforms_name(file) ? Format::kTransforms : Format::kNone;
  } catch (const Error&) {
    // A damaged file is judged by its name, and its reader says what is wrong.
    return is_transforms_name(file)            ? Format::kTransforms
           : file.filename() == "cameras.json" ? Format::kCamerasJson
                                               : Format::kNone;
  }
}

Format format_of(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return is_colmap(path) ? Format::kColmap : Format::kNone;
  if (!fs::is_regular_file(path, ignored)) return Format::kNone;
  if (path.extension() == ".json") return format_of_json(path);
  if (path.filename() == "poses_bounds.npy") return Format::kLlff;
  return is_par_file(path) ? Format::kMiddlebury : Format::kNone;
}

}  // namespace

fs::path cameras_at(const fs::path& path) {
  if (format_of(path) != Format::kNone) return path;
  const std::string name = path.filename().string();
  for (const char* part : {"cameras.bin", "images.bin", "cameras.txt", "images.txt"}) {
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    if (name == part && is_colmap(folder)) return folder;
  }
  return {};
}

fs::path cameras_in(const fs::path& folder) {
  std::error_code ignored;
  for (const char* name : {"transforms.json", "transforms_train.json"}) {
    if (fs::is_regular_file(folder / name, ignored)) return folder / name;
  }
  std::vector<fs::path> transforms, par;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored)) {
    if (is_transforms_name(entry.path())) transforms.push_back(entry.path());
    if (is_par_file(entry.path())) par.push_back(entry.path());
  }
  std::sort(transforms.begin(), transforms.end());
  std::sort(par.begin(), par.end());
  if (!transforms.empty()) return transforms.front();
  if (fs::is_regular_file(folder / "cameras.json", ignored)) return folder / "cameras.json";
  for (const char* model : {"", "sparse/0", "sparse", "colmap/sparse/0"}) {
    if (is_colmap(folder / model)) return (folder / model).lexically_normal();
  }
  if (!par.empty()) return par.front();
  return fs::is_regular_file(folder / "poses_bounds.npy", ignored) ? folder / "poses_bounds.npy" : fs::path();
}

CameraFile read_cameras(const fs::path& path, const fs::path& photos, PhotoFit fit) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw input_error(path.string(), "", "does not exist", "check the name");
  fs::path at = cameras_at(path);
  if (at.empty() && fs::is_directory(path, ignored)) at = cameras_in(path);
  switch (format_of(at)) {
    case Format::kTransforms:
      return read_transforms(at, photos, fit);
    case Format::kCamerasJson:
      return read_cameras_json(at, photos, fit);
    case Format::kColmap:
      return read_colmap(at, photos, fit);
    case Format::kMiddlebury:
      return read_middlebury(at, photos, fit);
    case Format::kLlff:
      return read_llff(at, photos, fit);
    case Format::kNone:
      break;
  }
  throw input_error(path.string(), "", "contains no known cameras",
                    "give a transforms.json, the cameras.json of 3DGS, a COLMAP model, a Middlebury _par.txt, or the "
                    "poses_bounds.npy of LLFF");
}

std::vector<std::string> write_cameras(const fs::path& file, const std::vector<Camera>& cameras) {
  if (file.extension() != ".json")
    throw usage_error(file.string(), "", "is in a format that cannot be written",
                      "cameras: transforms.json or cameras.json");
  if (file.filename() != "cameras.json") return write_transforms(file, cameras), std::vector<std::string>();
  std::vector<std::string> lost;
  bool centred = true, straight = true;
  for (const Camera& camera : cameras) {
    centred =
        centred && std::abs(camera.cx - 0.5 * camera.width) < 1e-6 && std::abs(camera.cy - 0.5 * camera.height) < 1e-6;
    straight = straight && camera.distortion == Camera().distortion;
  }
  if (!centred)
    lost.push_back(file.string() + ": cameras.json has no principal point; readers assume the image center");
  if (!straight) lost.push_back(file.string() + ": cameras.json has no lens distortion");
  write_cameras_json(file, cameras);
  return lost;
}

}  // namespace pliant
