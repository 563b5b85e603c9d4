#include "gaussians/io/cameras/cameras.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "gaussians/base/error.h"
#include "gaussians/io/cameras/cameras_json.h"
#include "gaussians/io/cameras/colmap.h"
#include "gaussians/io/cameras/llff.h"
#include "gaussians/io/cameras/middlebury.h"
#include "gaussians/io/cameras/ply_points.h"
#include "gaussians/io/cameras/transforms.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/files/paths.h"

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

/// Whether a transforms*.json is the array of poses, {"file_path", "transform"}, that `ns-export cameras` of nerfstudio
/// writes: it has no intrinsics.
bool is_pose_list(const fs::path& file) {
  std::error_code ignored;
  if (!is_transforms_name(file) || !fs::is_regular_file(file, ignored)) return false;
  std::ifstream in(file);
  char first = 0;
  if (!(in >> first) || first != '[') return false;
  try {
    const nlohmann::json json = read_json(file);
    return json.empty() || !json[0].contains("position");
  } catch (const Error&) {
    return false;  // its reader says what is damaged
  }
}

Format format_of_json(const fs::path& file) {
  if (is_pose_list(file)) return Format::kNone;
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

CameraFile read_format(const fs::path& file, const fs::path& photos, PhotoFit fit) {
  switch (format_of(file)) {
    case Format::kTransforms:
      return read_transforms(file, photos, fit);
    case Format::kCamerasJson:
      return read_cameras_json(file, photos, fit);
    case Format::kColmap:
      return read_colmap(file, photos, fit);
    case Format::kMiddlebury:
      return read_middlebury(file, photos, fit);
    case Format::kLlff:
      return read_llff(file, photos, fit);
    case Format::kNone:
      break;
  }
  throw input_error(file.string(), "", "contains no known cameras", "give a file or COLMAP model with cameras");
}

/// Of models with equally many images the first.
const NumberedModel& chosen(const std::vector<NumberedModel>& models, ColmapChoice choice) {
  if (choice == ColmapChoice::kFirst) return models.front();
  return *std::max_element(models.begin(), models.end(),
                           [](const NumberedModel& a, const NumberedModel& b) { return a.images < b.images; });
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

fs::path cameras_in(const fs::path& folder, ColmapChoice choice) {
  std::error_code ignored;
  for (const char* name : {"transforms.json", "transforms_train.json"}) {
    if (fs::is_regular_file(folder / name, ignored) && !is_pose_list(folder / name)) return folder / name;
  }
  std::vector<fs::path> transforms, par;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored)) {
    if (is_transforms_name(entry.path()) && !is_pose_list(entry.path())) transforms.push_back(entry.path());
    if (is_par_file(entry.path())) par.push_back(entry.path());
  }
  std::sort(transforms.begin(), transforms.end());
  std::sort(par.begin(), par.end());
  if (!transforms.empty()) return transforms.front();
  if (fs::is_regular_file(folder / "cameras.json", ignored)) return folder / "cameras.json";
  if (is_colmap(folder)) return folder.empty() ? fs::path(".") : tidy_path(folder);
  for (const char* name : {"sparse", "colmap/sparse"}) {
    const std::vector<NumberedModel> models = numbered_models_in(folder / name);
    if (!models.empty()) return tidy_path(chosen(models, choice).folder);
    if (is_colmap(folder / name)) return tidy_path(folder / name);
  }
  if (!par.empty()) return par.front();
  return fs::is_regular_file(folder / "poses_bounds.npy", ignored) ? folder / "poses_bounds.npy" : fs::path();
}

std::string other_models(const fs::path& cameras) {
  if (!is_colmap(cameras)) return "";
  const fs::path model = tidy_path(fs::absolute(cameras / "")).parent_path();
  std::string used, others;
  for (const NumberedModel& other : numbered_models_in(model.parent_path())) {
    const std::string name = (other.folder.parent_path().filename() / other.folder.filename()).string(),
                      images = std::to_string(other.images);
    if (other.folder == model)
      used = name + " with " + images + " images is used";
    else
      others += (others.empty() ? "" : ", ") + name + " has " + images;
  }
  return used.empty() || others.empty() ? "" : cameras.string() + ": " + used + "; " + others;
}

CameraFile read_cameras(const fs::path& path, const fs::path& photos, PhotoFit fit) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw input_error(path.string(), "", "does not exist", "check the name");
  const fs::path named = cameras_at(path);
  const bool sought = named.empty() && fs::is_directory(path, ignored);
  const fs::path at = sought ? cameras_in(path) : named;
  if (at.empty() && is_pose_list(path))
    throw input_error(path.string(), "", "lists poses without intrinsics, as `ns-export cameras` of nerfstudio writes",
                      "give a transforms.json with \"frames\" and fl_x, fl_y, cx, cy, w and h");
  if (at.empty())
    throw input_error(path.string(), "", "contains no known cameras",
                      "give a transforms.json, the cameras.json of 3DGS, a COLMAP model, a Middlebury _par.txt, or the "
                      "poses_bounds.npy of LLFF");
  CameraFile file = read_format(at, photos, fit);
  if (const std::string sentence = sought ? other_models(at) : ""; !sentence.empty()) file.warnings.push_back(sentence);
  return file;
}

fs::path points_beside(const fs::path& file) { return file.parent_path() / (file.stem().string() + "_points.ply"); }

std::vector<std::string> write_cameras(const fs::path& file, const std::vector<Camera>& cameras,
                                       const SparsePoints& points) {
  if (file.extension() != ".json")
    throw usage_error(file.string(), "", "is in a format that cannot be written",
                      "cameras: transforms.json or cameras.json");
  std::vector<std::string> lost;
  if (file.filename() != "cameras.json") {
    const fs::path points_file = points.empty() ? fs::path() : points_beside(file);
    if (!points.empty()) write_ply_points(points_file, points);
    write_transforms(file, cameras, points_file);
    return lost;
  }
  if (!points.empty())
    lost.push_back(file.string() + ": cameras.json does not name points: " + points.source + " are left out");
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
